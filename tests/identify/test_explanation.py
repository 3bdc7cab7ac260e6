"""What a diagnosis says: percent of the motion where the floor is a guess, and what to record of a driven motion."""

import numpy as np
import pytest

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.free_decay import FreeDecay
from mocks.generate import draw

FEW = (find_effect("quadratic_damping"),)


@pytest.fixture(scope="module")
def short():
    """Seven cycles of a cubic spring in one channel: too few for a curve that foretells."""
    sample = draw("cubic_stiffness", 0.1, 8, amplitude=0.02)
    cut = slice(None, int(sample.rate * 2.4))
    return diagnose(FreeDecay(sample.rate, displacement=sample.displacement[cut]), library=FEW)


def test_standard_errors_that_are_stated_are_those_of_the_misfit_above_the_floor(short):
    stated = short.baseline.stated(short.baseline.fit)
    assert not short.baseline.at_floor
    assert (
        stated.parameters["linear_stiffness.k"].std
        > 3.0 * short.baseline.fit.parameters["linear_stiffness.k"].std
    )
    assert np.all(stated.theta == short.baseline.fit.theta)


def test_what_is_left_is_said_in_percent_of_the_motion_where_the_floor_is_a_guess(short):
    assert short.verdict == "unknown_effect"
    assert "% of the motion (" in short.explanation
    assert "too few cycles for its large amplitudes to foretell its small ones" in short.explanation
