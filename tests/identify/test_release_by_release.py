"""What single releases name each by themselves, where one of them shows something else besides."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from identify.curves.confirm import confirmed, search_of
from identify.curves.release_by_release import confirm_releases
from identify.diagnosis.suspects import candidate_terms
from identify.effects.library import LIBRARY
from identify.fitting.initial_values import scales_of
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

K3 = 1.2e5
AMPLITUDES = (0.02, -0.019, 0.018)
NAMES = ("cubic_stiffness", "quadratic_damping", "signed_quadratic_stiffness", "time_varying_stiffness")


def releases(wandering: tuple[bool, ...]):
    """Return releases of one hard spring; where it wanders, time itself sways by 12 ms (0.3 rad) in 3 s."""
    found = []
    for i, (amplitude, wanders) in enumerate(zip(AMPLITUDES, wandering, strict=True)):
        hidden = {"parameters": {"cubic_stiffness": {"k3": K3}}, "amplitude": amplitude, "mu_0": 0.02}
        sample = draw("cubic_stiffness", 0.03, 20 + i, **hidden)
        time = np.arange(len(sample.displacement)) / sample.rate
        sway = 0.012 * np.sin(2.0 * np.pi * time / 3.0) if wanders else 0.0
        found.append(
            prepare(FreeDecay(sample.rate, displacement=CubicSpline(time, sample.displacement)(time + sway)))
        )
    return tuple(found)


def given(decays):
    terms = candidate_terms(base_model(), tuple(e for e in LIBRARY if e.name in NAMES), decays[0].window)
    return decays, base_model(), {}, terms, scales_of(decays[0], {})


def test_a_release_that_shows_something_else_besides_does_not_hide_what_the_others_name():
    decays = given(releases((True, False, False)))
    together = search_of(*decays)
    assert together is not None
    assert confirmed(*together).names == ()
    found = confirm_releases(*decays)
    assert found.names == ("cubic_stiffness",)
    assert found.effects[0].alone >= 2
    assert found.effects[0].strength == pytest.approx(K3, rel=0.1)
    assert found.found.typical("motion") < 0.5 * found.usual.typical("motion")


@pytest.mark.slow
def test_what_one_release_alone_names_is_not_named_of_all():
    assert confirm_releases(*given(releases((True, True, False)))).names == ()
