import pytest
from releases import drawn

from identify.diagnosis.linear_gain import Slope, worth_a_fit
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.initial_values import scales_of
from identify.model.model import Term, base_model

HIDDEN = ("cubic_stiffness", "quadratic_damping")
OTHERS = ("bilinear_stiffness", "quadratic_stiffness")


@pytest.mark.parametrize(("first", "second"), [HIDDEN, HIDDEN[::-1]])
def test_of_two_hidden_effects_the_one_that_is_not_yet_in_the_model_is_worth_a_fit_and_others_are_not(
    first, second
):
    prepared, _ = drawn("+".join(HIDDEN), 0.01, 303)
    model = base_model().plus(Term(find_effect(first)))
    found = fit_baseline((prepared,), model).fit
    terms = tuple(Term(find_effect(name)) for name in (second, *OTHERS))
    kept = worth_a_fit((prepared,), Slope.of(found), terms, scales_of(prepared, {}), 1.1 * found.degrees)
    assert [term.effect.name for term in kept] == [second]


def test_near_the_goal_every_effect_is_worth_a_fit():
    prepared, _ = drawn(None, 0.0, 304)
    found = fit_baseline((prepared,), base_model()).fit
    terms = tuple(Term(find_effect(name)) for name in OTHERS)
    assert (
        worth_a_fit((prepared,), Slope.of(found), terms, scales_of(prepared, {}), float(found.degrees))
        == terms
    )
