"""What is to be found of a model: physics once, and what each release has of its own."""

import pytest
from test_fit import fitted

from identify.effects.library import find_effect
from identify.fitting.parameter_layout import NOWHERE, ParameterLayout, in_unit
from identify.model.model import Term, base_model

PHYSICS = ["linear_stiffness.k", "coulomb_friction.mu_0", "viscous_damping.mu_1"]
OWN = ["displacement", "velocity", "lag", "gain", "displacement_offset", "acceleration_offset"]


def names(model, *windows):
    return [unknown.name for unknown in ParameterLayout(model, windows, 25.0).unknowns]


def test_one_release_needs_no_numbers():
    window = fitted()[0].window
    assert names(base_model(), window) == [*PHYSICS, *OWN]


def test_several_releases_share_the_physics_and_number_the_rest():
    window = fitted()[0].window
    expected = [*PHYSICS, *(f"{name}[{i}]" for i in range(2) for name in OWN)]
    assert names(base_model(), window, window) == expected


def test_what_is_held_is_no_unknown_and_a_fault_is_found_in_each_release():
    window = fitted()[0].window
    model = base_model().plus(Term(find_effect("end_stop"), {"side": 1.0}))
    model = model.plus(Term(find_effect("offset_drift"), {"channel": "acceleration"}))
    found = names(model, window, window)
    assert found[3:5] == ["end_stop.ks", "end_stop.gap"]
    assert [name for name in found if name.startswith("offset_drift")] == [
        "offset_drift.rate[0]",
        "offset_drift.rate[1]",
    ]


def test_a_fault_that_every_fit_allows_for_has_no_unknown():
    window = fitted()[0].window
    for name in ("channel_lag", "channel_gain"):
        assert names(base_model().plus(Term(find_effect(name))), window) == [*PHYSICS, *OWN]


def test_internal_states_are_unknowns_where_the_motion_before_the_release_does_not_give_them():
    window = fitted()[0].window
    yields, relaxes = (base_model().plus(Term(find_effect(n))) for n in ("hysteresis", "maxwell_element"))
    assert "hysteresis.state0" in names(yields, window)
    assert "maxwell_element.state0" in names(relaxes, window.with_(pre_release=None))
    if window.pre_release is not None:
        assert "maxwell_element.state0" not in names(relaxes, window)


def test_without_an_acceleration_there_is_neither_lag_nor_gain():
    window = fitted()[0].window
    alone = window.with_(readings={"displacement": window.readings["displacement"]})
    (places,) = ParameterLayout(base_model(), (alone,), 25.0).releases
    assert (places.lag, places.gain) == (NOWHERE, NOWHERE)


def test_a_shared_parameter_is_the_other_effects_unknown():
    layout = ParameterLayout(
        base_model().plus(Term(find_effect("time_varying_stiffness"))), (fitted()[0].window,), 25.0
    )
    shared = layout.cells[-1]
    assert (shared.row, shared.column) == (0, 1)
    assert layout.unknowns[shared.unknown].name == "linear_stiffness.k"


@pytest.mark.parametrize(
    ("unit", "angle"),
    [("m/s^2", "rad/s^2"), ("1/(m^2 s^2)", "1/(rad^2 s^2)"), ("1/s", "1/s"), ("s/m^2", "s/rad^2")],
)
def test_a_unit_is_written_in_that_of_the_displacement(unit, angle):
    assert in_unit(unit, "rad") == angle
    assert in_unit(unit, "m") == unit


def test_a_fits_parameters_and_nuisances_are_all_it_found():
    found = fitted()[2]
    assert [*found.parameters] == PHYSICS
    assert [*found.nuisances] == OWN
    assert found.nuisance("gain", 0) is found.values["gain"]
    assert found.of(found.model.terms[0]) == {"k": found.values["linear_stiffness.k"]}
    assert found.of_release(0) == {name: estimate.value for name, estimate in found.values.items()}
