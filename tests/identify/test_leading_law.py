"""Which law leads: the simple before those that bend, none where a drift leaves nearly as little, memory by both faces."""

import numpy as np
import pytest

from identify.curves.averaged_law import AveragedLaw
from identify.curves.confirm import both_faces
from identify.curves.curve_regression import MotionError, Strengths
from identify.curves.held_out import HeldOut
from identify.curves.leading_law import choose
from identify.effects.library import find_effect
from identify.model.model import Term

BEFORE = 100.0


def led(left: dict[str, float], *, one_record: bool = True):
    """Return the choice among effects by the error that each leaves of 100 %."""
    nothing = np.zeros(0)
    laws = [AveragedLaw(Term(find_effect(name)), {}, nothing, nothing, (), nothing) for name in left]
    columns = list(range(len(laws)))
    errors = dict(enumerate(left.values()))
    return choose(laws, columns, lambda near: near, errors, BEFORE, one_record=one_record), list(left)


def test_a_law_that_can_bend_does_not_lead_before_a_plain_one_that_leaves_nearly_as_little():
    chosen, names = led({"freeplay": 13.0, "quintic_stiffness": 14.0})
    assert names[chosen.lead] == "quintic_stiffness"
    assert chosen.rivals == ("freeplay",)
    chosen, names = led({"freeplay": 4.0, "quintic_stiffness": 14.0})
    assert names[chosen.lead] == "freeplay"


@pytest.mark.parametrize(("drift", "told_apart"), [(2.9, False), (3.1, True), (29.0, True)])
def test_a_drift_that_leaves_three_times_as_much_is_told_apart(drift: float, told_apart: bool):
    chosen, _ = led({"pendulum_stiffness": 1.0, "settling_stiffness": drift})
    assert (chosen.lead is not None) == told_apart
    assert chosen.rivals == ()


def test_several_releases_tell_a_drift_apart_that_one_record_does_not():
    left = {"quintic_stiffness": 7.0, "settling_stiffness": 14.0}
    assert led(left)[0].lead is None
    assert led(left, one_record=False)[0].lead == 0
    assert led({"quintic_stiffness": 7.0, "settling_stiffness": 10.0}, one_record=False)[0].lead is None


def test_a_drift_is_not_told_apart_by_errors_too_small_to_be_worth_a_name():
    chosen, _ = led({"cubic_stiffness": 0.01, "settling_stiffness": 1.0})
    assert chosen.lead is None


def test_a_drift_that_leaves_less_than_any_law_of_the_amplitude_leaves_no_name():
    chosen, _ = led({"cubic_stiffness": 30.0, "time_varying_stiffness": 1.0})
    assert chosen.lead is None
    assert chosen.drifts == ("time_varying_stiffness",)


def test_of_two_laws_that_curves_cannot_part_the_first_leads_whichever_leaves_a_trifle_less():
    for left in (
        {"cubic_damping": 2.0, "position_dependent_damping": 1.9},
        {"cubic_damping": 1.9, "position_dependent_damping": 2.0},
    ):
        chosen, names = led(left)
        assert names[chosen.lead] == "cubic_damping"
    chosen, names = led({"cubic_damping": 3.0, "position_dependent_damping": 1.9})
    assert names[chosen.lead] == "position_dependent_damping"


def held(phase: float, envelope: float) -> HeldOut:
    errors = (MotionError(envelope, phase, 0.0),) * 3
    return HeldOut(Strengths((), np.zeros(0), {}), errors, errors, False)


@pytest.mark.parametrize(
    ("after", "taken"), [((2.0, 12.0), False), ((2.0, 5.0), True), ((2.0, 0.4), True), ((0.1, 9.0), False)]
)
def test_memory_that_moves_the_frequency_must_explain_the_loss_too(after: tuple[float, float], taken: bool):
    before = held(40.0, 13.0)
    assert both_faces(Term(find_effect("hysteresis")), before, held(*after), "phase") == taken
    assert both_faces(Term(find_effect("cubic_stiffness")), before, held(*after), "phase")
