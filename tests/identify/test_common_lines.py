"""Lines of both channels: hum stays, and is none that a motion makes; a mode that dies, or shaking, is no hum."""

import numpy as np
import pytest
from releases import drawn

from identify.fitting.baseline import fit_baseline
from identify.fitting.common_lines import common_lines
from identify.model.model import base_model
from mocks.imperfections import HUM


def base(*what, **fixed):
    prepared, truth = drawn(*what, **fixed)
    return prepared, truth, fit_baseline((prepared,), base_model())


def test_a_second_mode_that_dies_is_no_hum():
    _, truth, found = base("second_mass", 0.03, 62000)
    line = truth["parameters"]["w2"] / (2.0 * np.pi)
    assert not [
        f for lines in common_lines(found.fit, 0).values() for f in lines if abs(f.frequency - line) < 1.0
    ]


@pytest.mark.parametrize("stiffness", [613.0, 626.0])
def test_hum_is_seen_beside_a_second_mode_at_a_high_harmonic_too(stiffness):
    """The 13th harmonic is at 51.2 and 51.8 Hz; hum at 50 lies a third and nearly half of the motion's frequency off it."""
    _, _, found = base("second_mass", 0.03, 62000, imperfections=(HUM,), stiffness=stiffness)
    for lines in common_lines(found.fit, 0).values():
        assert [line.frequency for line in lines] == [pytest.approx(50.0, abs=0.06)]
        assert lines[0].uncertainty < 0.05  # of a line three times the noise over four seconds
