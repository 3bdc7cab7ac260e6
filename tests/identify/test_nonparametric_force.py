"""The free form: what it gives along a coordinate is the force that is missing there."""

import numpy as np
import pytest
from releases import ready

from identify.fitting.baseline import fit_baseline
from identify.judging.nonparametric_force import free_form
from identify.model.model import base_model
from mocks.generate import draw


def missing(hidden, strength, seed, coordinate):
    sample = draw(hidden, strength, seed)
    baseline = fit_baseline((ready(sample.rate, sample.displacement, sample.acceleration),), base_model())
    shape = next(s for s in free_form(baseline, baseline.fit).shapes if s.coordinate == coordinate)
    return shape, sample.truth


def test_a_stiffness_that_drifts_is_given_as_its_force_at_the_largest_displacement():
    shape, truth = missing("time_varying_stiffness", 0.02, 3, "time (stiffness)")
    slope = np.polyfit(shape.position, shape.force, 1, w=1.0 / shape.std)[0]
    drift = truth["parameters"]["rate"] * truth["stiffness_per_mass"]
    assert shape.at == pytest.approx(abs(truth["from_m"]), rel=0.1)  # it is used from a quarter of a cycle on
    assert slope == pytest.approx(drift * shape.at, rel=0.3)  # four seeds: within 1 %; a mean over a bin is 0
    assert shape.where == "at 0.019 m"


def test_a_spring_that_hardens_is_given_as_its_force_at_each_displacement():
    shape, truth = missing("cubic_stiffness", 0.02, 4, "displacement")
    hardening = truth["parameters"]["k3"]
    found = np.polyfit(shape.position, shape.force, 3, w=1.0 / shape.std)[0]
    assert found == pytest.approx(hardening, rel=0.3)  # four seeds: within 2 %
