from functools import cache

import numpy as np
import pytest
from releases import drawn

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.harmonic_residual import harmonic_residual
from identify.fitting.segments import first_cycles
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from identify.priors import BENEFIT_OF_DOUBT
from mocks.generate import draw


@cache
def asked(effect, strength, seed):
    return harmonic_residual(fit_baseline((drawn(effect, strength, seed)[0],), base_model()).fit)


@pytest.mark.parametrize("seed", [330, 331])
def test_a_model_that_lacks_nothing_leaves_no_more_at_the_harmonics_than_between(seed):
    found = asked(None, 0.0, seed)
    assert found.p_value > 1e-3  # 1 in 1000 of sound records; the bench of regimes has the distribution
    assert 0.4 < found.ratio < 1.9  # some 60 degrees of freedom on either side: 3.5 standard errors


def test_a_spring_that_stiffens_by_a_thousandth_stands_at_the_harmonics():
    # of the total force 0.1 %, ten times what the noise leaves open: no level of the noise is needed to see it
    found = asked("cubic_stiffness", 0.001, 332)
    assert found.p_value < 1e-12
    assert found.ratio > 5.0


def test_four_cycles_are_too_few_to_tell_harmonics_from_what_lies_between():
    # bins a quarter of the frequency apart: none lies four bins off a harmonic
    short = first_cycles(drawn(None, 0.0, 330)[0], 4.0)
    assert harmonic_residual(fit_baseline((short,), base_model()).fit) is None


def test_the_same_fit_gives_the_same_answer():
    fit = fit_baseline((drawn(None, 0.0, 330)[0],), base_model()).fit
    assert harmonic_residual(fit) == harmonic_residual(fit)


def in_one_channel(effect, strength, seed):
    """Return a fit of the usual model to a record that begins in mid-decay, so that its floor is a guess."""
    sample = draw(effect, strength, seed)
    first = int((sample.truth["released_at_s"] + 0.1) * sample.rate)
    decay = FreeDecay(sample.rate, displacement=np.asarray(sample.displacement)[first:])
    return fit_baseline((prepare(decay),), base_model())


def test_a_guessed_floor_does_not_excuse_what_stands_at_the_harmonics():
    # two ten-thousandths of the force: chi-square alone, with its benefit of doubt, would let it pass
    found = in_one_channel("cubic_stiffness", 0.0002, 703)
    assert not found.floor_is_sure
    assert found.fit.reduced < 1.0 + BENEFIT_OF_DOUBT
    assert not found.adequate(found.fit)
    assert not found.at_floor
    asked = found.harmonics(found.fit)
    assert asked.against
    assert "): more than noise explains" in asked.sentence
    assert (
        found.stated(found.fit).values["linear_stiffness.k"].std
        > 1.4 * found.fit.values["linear_stiffness.k"].std
    )


def test_a_model_that_lacks_nothing_is_adequate_at_a_guessed_floor():
    found = in_one_channel(None, 0.0, 703)
    assert found.adequate(found.fit)
    assert found.harmonics(found.fit).p_value > 1e-3
    assert "): no more than noise explains" in found.harmonics(found.fit).sentence
    assert found.stated(found.fit) is found.fit


def test_a_sure_floor_is_not_asked_about_harmonics():
    found = fit_baseline((drawn(None, 0.0, 330)[0],), base_model())
    assert found.floor_is_sure
    assert found.harmonics(found.fit) is None


def test_a_diagnosis_at_a_guessed_floor_says_what_stands_at_the_harmonics():
    # an effect that is not in the library: nothing may be called adequate, and nothing is named
    sample = draw("cubic_stiffness", 0.0002, 703)
    first = int((sample.truth["released_at_s"] + 0.1) * sample.rate)
    decay = FreeDecay(sample.rate, displacement=np.asarray(sample.displacement)[first:])
    found = diagnose(decay, library=(find_effect("quadratic_damping"),))
    assert found.verdict in ("unknown_effect", "unconfirmed")
    assert found.harmonics.against
    assert found.harmonics.sentence in found.explanation
    assert found.shares == ()
