"""A fit that has lost its spring, and channels that together have too stiff a one, are refused in words."""

from dataclasses import replace

import numpy as np
import pytest

from identify.comparison.compare import compare_fitted
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit_at
from identify.fitting.problem import Problem
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw


def test_a_model_without_a_spring_is_refused_in_words():
    time = np.arange(800) / 40.0
    noise = 1e-4 * np.random.default_rng(2).standard_normal(800)
    prepared = prepare(FreeDecay(40.0, displacement=0.1 * np.exp(-0.05 * time) * np.cos(8.0 * time) + noise))
    baseline = fit_baseline((prepared,), base_model())
    problem = Problem(base_model(), baseline.fit.windows, baseline.fit.frequency)
    overdamped = {"linear_stiffness.k": 0.0, "viscous_damping.mu_1": 160.0}
    lost = fit_at(problem, problem.theta(baseline.fit.point | overdamped))
    with pytest.raises(NotIdentifiable, match="lost its spring"):
        compare_fitted(replace(baseline, fit=lost))


def test_channels_that_clip_together_show_no_spring_and_are_refused_in_words():
    """A motion whose damping wanders below none: it grows until both channels clip."""
    parameters = {"wandering_damping": {"s": 0.02217, "walk": 8330.0}}
    sample = draw("wandering_damping", 0.02, 882, seconds=40.0, mu_0=0.003, mu_1=0.02, parameters=parameters)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    with pytest.raises(
        NotIdentifiable, match=r"no restoring force that these readings could show: .* does a channel clip"
    ):
        prepare(decay)
