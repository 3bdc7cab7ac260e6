"""The pendulum: an effect in a file of its own, found where it is and never offered where it has no meaning."""

from functools import cache

import numpy as np
import pytest
from releases import drawn
from scipy.integrate import solve_ivp
from scipy.special import ellipk, j1
from specimens import among, diagnosed

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.effect import Scales
from identify.effects.library import LIBRARY, find_effect
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import initial_values
from identify.free_decay import FreeDecay
from identify.judging.suspects import candidate_terms
from identify.model.equivalent_linearisation import average
from identify.model.model import Term, base_model
from identify.preprocessing.prepared_decay import prepare

RATE, REST, SECONDS = 128.0, 2.0, 24.0
K, MU_0, MU_1 = 31.0, 0.05, 0.06
RELEASED_AT = 0.8  # rad
NOISE_ANGLE, NOISE_ACCELERATION = 2e-4, 1e-2  # rad, rad/s^2


def motion(time):
    """Return angle and angular acceleration of k sin u with dry and viscous friction, by an integrator of its own.

    It runs from reversal to reversal, so that no step sees the friction jump.
    """

    def slope(t, y):
        return [y[1], -K * np.sin(y[0]) - MU_1 * y[1] - MU_0 * np.sign(y[1])]

    def reversal(t, y):
        return y[1]

    reversal.terminal = True
    state = np.empty((2, len(time)))
    begin, angle = 0.0, RELEASED_AT
    while begin < time[-1]:  # at the end it still swings by 0.3 rad, and friction holds it below 0.002
        started = [angle, -1e-12 * np.sign(angle)]
        run = solve_ivp(
            slope,
            (begin, time[-1] + 1.0),
            started,
            events=reversal,
            dense_output=True,
            rtol=1e-10,
            atol=1e-12,
        )
        inside = (time >= begin) & (time <= run.t[-1])
        state[:, inside] = run.sol(time[inside])
        begin, angle = run.t[-1], run.y[0, -1]
    return state[0], np.array([slope(0.0, y)[1] for y in state.T])


@cache
def swung():
    u, a = motion(np.arange(int(SECONDS * RATE)) / RATE)
    draw = np.random.default_rng(8)
    u = np.concatenate([np.full(int(REST * RATE), RELEASED_AT), u])
    a = np.concatenate([np.zeros(int(REST * RATE)), a])
    decay = FreeDecay(
        RATE,
        displacement=u + NOISE_ANGLE * draw.standard_normal(len(u)),
        acceleration=a + NOISE_ACCELERATION * draw.standard_normal(len(a)),
        unit="rad",
    )
    return prepare(decay)


@cache
def found():
    return diagnosed(swung())


def test_the_pendulum_is_at_the_floor_with_its_effect_and_far_above_without():
    ground = first_step((swung(),))
    there = add_effect(ground, find_effect("pendulum_stiffness"))
    assert ground.error.chi_square > 20.0
    assert there.at_floor
    g, k = there.fit.values["pendulum_stiffness.g"], there.fit.values["linear_stiffness.k"]
    assert g.unit == "1/s^2"
    # All of the stiffness is gravity's; 4 standard errors: 1 in 16000 by chance.
    assert abs(g.value - K) < 4.0 * g.std
    assert abs(k.value - K) < 4.0 * k.std


@pytest.mark.slow
def test_the_diagnosis_names_it():
    assert found().verdict == "missing_effect"
    assert found().named == ("pendulum_stiffness",)


@pytest.mark.slow
def test_a_cubic_spring_does_not_do_what_the_sine_does():
    cubic = next(s for s in found().suspects if s.effect.name == "cubic_stiffness")
    assert found().suspects[0].evidence - cubic.evidence > 10.0
    assert cubic.error_after > 1.2


def test_it_is_offered_for_angles_only():
    window = swung().window
    offered = [
        {t.effect.name for t in candidate_terms(base_model(), LIBRARY, window.with_(unit=unit))}
        for unit in ("rad", "m", "V")
    ]
    assert offered[0] - offered[1] == {"pendulum_stiffness"}
    assert offered[1] == offered[2]


def test_to_add_it_to_a_displacement_in_metres_is_refused_with_the_reason():
    prepared, _ = drawn(None, 0.0, 7100)
    with pytest.raises(
        NotIdentifiable, match="pendulum_stiffness acts on displacements in rad; this record is in m"
    ):
        add_effect(first_step((prepared,)), find_effect("pendulum_stiffness"))


def test_its_signature_is_that_of_the_bessel_function():
    """For g (sin u - u): dw2 = g (2 J1(A)/A - 1), from the first Fourier coefficient of sin(A cos theta)."""
    amplitude = np.array([0.1, 0.5, 1.0])
    found = average(find_effect("pendulum_stiffness"), {"g": K}, np.sqrt(K), amplitude)
    np.testing.assert_allclose(found.stiffening, K * (2 * j1(amplitude) / amplitude - 1), rtol=1e-9)
    exact = np.sqrt(K) * np.pi / (2.0 * ellipk(np.sin(amplitude / 2.0) ** 2))
    # First order in g: the exact frequency differs by the fourth power of the amplitude, 3 % of the shift at 1 rad.
    np.testing.assert_allclose(np.sqrt(K + found.stiffening) - np.sqrt(K), exact - np.sqrt(K), rtol=0.05)


def test_a_fit_begins_at_the_right_damping_where_the_friction_would_come_out_negative():
    k, mu_1, time = 37.2, 0.06, np.arange(600) / 20.0
    run = solve_ivp(
        lambda t, y: [y[1], -k * np.sin(y[0]) - mu_1 * y[1]], (0.0, 30.0), [1.6, 0.0], t_eval=time, rtol=1e-9
    )
    angle = run.y[0] + 2e-3 * np.random.default_rng(2).standard_normal(len(time))
    prepared = prepare(FreeDecay(20.0, displacement=angle, unit="rad"))
    begin = initial_values((prepared,), base_model().plus(Term(find_effect("pendulum_stiffness"))), {})
    assert begin["coulomb_friction.mu_0"] == 0.0
    # Cut off afterwards, the negative friction would have left 7 % too much viscous damping.
    assert begin["viscous_damping.mu_1"] == pytest.approx(mu_1, rel=0.02)


@pytest.mark.parametrize("degrees", [20.0, 90.0, 130.0, 150.0, 165.0])
def test_a_swing_of_any_amplitude_may_be_gravitys(degrees: float):
    """The exact frequency of a swing against gravity alone: at 165 degrees a quarter of the stiffness about rest."""
    amplitude = np.radians(degrees)
    seen = np.sqrt(K) * np.pi / (2.0 * ellipk(np.sin(amplitude / 2.0) ** 2))
    scales = Scales(amplitude, float(seen), 8.0, 100.0, {}, {})
    effect = find_effect("pendulum_stiffness")
    assert effect.plausible({"g": K}, scales)
    # A softening that gravity would have to be fifteen times the spring for, at angles at which none falls over.
    assert degrees > 60.0 or not effect.plausible({"g": 15.0 * K}, scales)


def test_gravity_is_named_on_a_pendulum_that_swings_through_more_than_half_a_turn():
    """The model leaves noise alone, so that no name that leaves more may stand before it."""
    time = np.arange(800) / 100.0
    run = solve_ivp(
        lambda t, y: [y[1], -57.0 * np.sin(y[0]) - 0.05 * y[1]],
        (0.0, 8.0),
        [np.radians(130.0), 0.0],
        t_eval=time,
        rtol=1e-10,
    )
    angle = run.y[0] + 1e-3 * np.random.default_rng(3).standard_normal(len(time))
    springs = among("pendulum_stiffness", "cubic_stiffness", "settling_stiffness", "hysteresis")
    swing = diagnose(FreeDecay(100.0, displacement=angle, unit="rad"), library=springs)
    assert swing.named == ("pendulum_stiffness",)
    assert "one and a half" not in swing.next_experiment  # 195 degrees: it would not come back
    assert swing.suspects[0].error_after < 1.3  # the noise is drawn: 1, and six errors of 0.05


@pytest.mark.slow
def test_drag_beside_gravity_does_not_make_a_cubic_spring_of_it():
    """Neither reaches the floor alone: of two that leave next to nothing the one without a constant of its own leads."""
    angle, drag = 0.8, 0.012

    def slope(t: float, y: np.ndarray) -> list[float]:
        return [
            y[1],
            -21.0 * np.sin(y[0]) - 0.012 * y[1] - drag * y[1] * abs(y[1]) - 0.005 * np.tanh(1e4 * y[1]),
        ]

    time = np.arange(2400) / 100.0
    swing = solve_ivp(
        slope, (0.0, 24.5), (angle, 0.0), t_eval=time + 0.4, rtol=1e-9, atol=1e-11, method="LSODA"
    )
    noise = 2e-3 * angle * np.random.default_rng(5).standard_normal(len(time))
    assert diagnosed(FreeDecay(100.0, swing.y[0] + noise, unit="rad")).named[0] == "pendulum_stiffness"
