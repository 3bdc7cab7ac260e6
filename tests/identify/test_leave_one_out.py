"""Leaving one release out: physics that is shared carries over, physics that is not does not."""

import numpy as np
import pytest

from identify.effects.stiffness import CUBIC_STIFFNESS
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.initial_values import initial_values
from identify.fitting.segments import segments_of
from identify.fitting.validation import leave_one_out
from identify.free_decay import FreeDecay
from identify.model.model import Term, base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw


def prepared(sample):
    return prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration))


@pytest.fixture(scope="module")
def both():
    """Return two releases of one bench with one cubic spring, and its strength."""
    large = draw("cubic_stiffness", 0.01, 5, amplitude=0.02)
    k3 = large.truth["parameters"]["k3"]
    small = draw("cubic_stiffness", 0.01, 5, amplitude=-0.012, parameters={"cubic_stiffness": {"k3": k3}})
    return segments_of((prepared(large), prepared(small))), k3


def test_the_right_physics_predicts_the_release_it_has_not_seen(both):
    decays, k3 = both
    model = base_model().plus(Term(CUBIC_STIFFNESS))
    found = fit_baseline(decays, model, initial_values(decays, model, {})).fit
    assert found.values["cubic_stiffness.k3"].value == pytest.approx(k3, rel=0.01)
    # The floor is known to a tenth; the held physics adds its own small error.
    assert [one.chi_square for one in leave_one_out(found)] == pytest.approx([1.0, 1.0], abs=0.3)


def test_physics_that_lacks_an_effect_does_not(both):
    decays, _ = both
    found = fit_baseline(decays, base_model()).fit
    left = leave_one_out(found)
    assert len(left) == 2
    assert min(one.chi_square for one in left) > 10
    assert min(one.motion_percent for one in left) > 0.5
    assert all(np.isfinite(one.motion_percent) for one in left)


def test_a_release_in_segments_is_left_out_as_a_whole():
    # 24 s at some 4 Hz: more than 60 cycles, so that the first is fitted in two segments.
    long = prepared(draw(None, 0.0, 4, amplitude=0.02, seconds=24.0, mu_0=0.02, mu_1=0.05))
    short = prepared(draw(None, 0.0, 4, amplitude=0.015, seconds=8.0, mu_0=0.02, mu_1=0.05))
    found = fit_baseline(segments_of((long, short)), base_model()).fit
    assert [window.release for window in found.windows] == [0, 0, 1]
    left = leave_one_out(found)
    assert len(left) == 2
    # Nothing is hidden: each release is predicted by the other, to the floor and the held physics' own error.
    assert [one.chi_square for one in left] == pytest.approx([1.0, 1.0], abs=0.5)


def test_one_release_cannot_be_left_out(both):
    decays, _ = both
    with pytest.raises(NotIdentifiable):
        leave_one_out(fit_baseline(decays[:1], base_model()).fit)
