import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY, find_effect
from identify.model.simulate import make_system, simulate, substeps_for

W0 = np.sqrt(614.0)
RATE = 256.0


def run(effects, table, linear, start=(0.02, 0.0), samples=2048, lag=0.0, states=None, rate=RATE, time=0.0):
    system = make_system(tuple(find_effect(e) for e in effects))
    rows = np.zeros((len(effects), 6))
    for row, values in zip(rows, table, strict=True):
        row[: len(values)] = values
    return simulate(
        system,
        np.array(linear),
        rows,
        start=start,
        states=np.zeros((len(effects), 2)) if states is None else np.array(states),
        samples=samples,
        rate=rate,
        substeps=substeps_for(W0, rate, nonsmooth=system.nonsmooth),
        time=time,
        lag=lag,
    )


def test_dry_friction_takes_4_mu_0_over_k_from_each_cycle_and_stops_where_the_closed_form_says():
    mu_0, k, start = 0.13, 614.0, 0.02
    found = run((), (), (k, 0.0, mu_0), (start, 0.0), 4096)
    # Each half-cycle is a cosine about +-mu_0/k: the turning points fall by 2 mu_0/k until friction holds.
    turning, sign = start, 1.0
    while abs(turning) > mu_0 / k:
        turning = -(turning - 2.0 * sign * mu_0 / k)
        sign = -sign
    assert found.displacement[-1] == pytest.approx(
        turning, abs=1e-8
    )  # fourth-order steps lose 1e-7 of the amplitude over 47 half-cycles
    assert found.acceleration[-1] == 0.0
    half = np.pi / np.sqrt(k)
    cycle = np.interp(2.0 * half, np.arange(4096) / RATE, found.displacement)
    assert cycle == pytest.approx(start - 4.0 * mu_0 / k, abs=2e-5)  # linear interpolation between samples


def test_without_dry_friction_the_decay_is_the_exponential_of_the_closed_form():
    k, mu_1 = 614.0, 0.277
    found = run((), (), (k, mu_1, 0.0))
    t = np.arange(2048) / RATE
    w = np.sqrt(k - mu_1**2 / 4.0)
    exact = 0.02 * np.exp(-mu_1 * t / 2.0) * (np.cos(w * t) + mu_1 / (2.0 * w) * np.sin(w * t))
    assert np.max(np.abs(found.displacement - exact)) < 1e-7


@pytest.mark.parametrize("lag", [-0.6 / RATE, -1.0 / RATE, -3.4 / RATE])
def test_a_channel_that_is_early_reads_on_beyond_the_end_of_the_run(lag):
    k, mu_1 = 614.0, 0.277
    found = run((), (), (k, mu_1, 0.0), samples=1000, lag=lag)
    t = np.arange(1000) / RATE - lag
    w = np.sqrt(k - mu_1**2 / 4.0)
    exact = 0.02 * np.exp(-mu_1 * t / 2.0) * (np.cos(w * t) + mu_1 / (2.0 * w) * np.sin(w * t))
    # The parabola from the last step on errs by (w dt)^3/6 of the amplitude.
    assert (
        np.max(np.abs(found.displacement - exact))
        < 0.02 * (w * max(-lag - 1.0 / RATE, 0.0)) ** 3 / 6.0 + 1e-7
    )


def test_a_hardening_spring_has_the_period_of_the_elliptic_integral():
    k, k3, a = 614.0, 5e5, 0.02
    found = run(("cubic_stiffness",), ((k3,),), (k, 0.0, 0.0), (a, 0.0), 4096)
    m = k3 * a**2 / (2.0 * (k + k3 * a**2))
    period = 4.0 * ellipk(m) / np.sqrt(k + k3 * a**2)
    u, v = found.displacement, found.velocity
    crossings = np.flatnonzero((u[:-1] < 0.0) & (u[1:] >= 0.0))
    times = (crossings - u[crossings] / (u[crossings + 1] - u[crossings])) / RATE
    assert np.mean(np.diff(times)) == pytest.approx(
        period, rel=2e-6
    )  # the crossings are interpolated linearly
    energy = v**2 / 2.0 + k * u**2 / 2.0 + k3 * u**4 / 4.0
    assert np.ptp(energy) < 3e-5 * energy[0]


def test_a_late_reading_is_the_same_motion_read_earlier():
    linear = (614.0, 0.277, 0.13)
    fine = run((), (), linear, samples=4096, rate=1024.0)
    late = run((), (), linear, samples=1024, lag=1.0 / 1024.0)
    assert (
        np.max(np.abs(late.displacement[1:] - fine.displacement[3:-1:4][:1023])) < 1e-7
    )  # the two runs step differently


@pytest.mark.parametrize(
    ("name", "p", "states", "rhs"),
    [
        ("maxwell_element", (60.0, 0.05), 1, lambda u, v, z: (60.0 * (u - z[0]), [(u - z[0]) / 0.05])),
        (
            "second_mass",
            (0.03, 70.0, 0.02),
            2,
            lambda u, v, z: (
                0.03 * (4900.0 * (u - z[0]) + 2.8 * (v - z[1])),
                [z[1], 4900.0 * (u - z[0]) + 2.8 * (v - z[1])],
            ),
        ),
    ],
)
def test_memory_agrees_with_an_independent_integrator(name, p, states, rhs):
    found = run((name,), (p,), (614.0, 0.277, 0.0), samples=1024)

    def slope(t, y):
        force, rates = rhs(y[0], y[1], y[2:])
        return [y[1], -614.0 * y[0] - 0.277 * y[1] - force, *rates]

    t = np.arange(1024) / RATE
    exact = solve_ivp(
        slope, (0.0, t[-1]), [0.02, 0.0, *[0.0] * states], t_eval=t, rtol=1e-10, atol=1e-14, method="DOP853"
    )
    assert np.max(np.abs(found.displacement - exact.y[0])) < 2e-7


def in_pieces(slope, start, until, samples):
    """Displacement at the samples of a motion against dry friction, from one turning point to the next."""
    t = np.arange(samples) / RATE
    found, now, y, s = np.zeros(samples), 0.0, start, -1.0

    def turns(t, y, s):
        return y[1]

    turns.terminal = True
    while now < until:
        turns.direction = -s
        run = solve_ivp(
            slope,
            (now, until),
            y,
            args=(s,),
            events=turns,
            dense_output=True,
            rtol=1e-11,
            atol=1e-14,
            method="DOP853",
        )
        here = (t >= now) & (t <= run.t[-1])
        found[here] = run.sol(t[here])[0]
        now, y, s = run.t[-1], [run.y[0, -1], 0.0, *run.y[2:, -1]], -s
    return found


@pytest.mark.parametrize(
    ("name", "p", "states", "rhs"),
    [
        ("cubic_stiffness", (5e4,), 0, lambda u, v, z: (5e4 * u**3, [])),
        ("quadratic_damping", (2.0,), 0, lambda u, v, z: (2.0 * v * abs(v), [])),
        ("maxwell_element", (60.0, 0.05), 1, lambda u, v, z: (60.0 * (u - z[0]), [(u - z[0]) / 0.05])),
    ],
)
def test_a_mass_turns_against_dry_friction_where_an_independent_integrator_says(name, p, states, rhs):
    mu_0, samples = 0.1, 512
    found = run((name,), (p,), (614.0, 0.277, mu_0), samples=samples)

    def slope(t, y, s):
        force, rates = rhs(y[0], y[1], y[2:])
        return [y[1], -614.0 * y[0] - 0.277 * y[1] - force - s * mu_0, *rates]

    exact = in_pieces(slope, [0.02, 0.0, *[0.0] * states], (samples - 1) / RATE, samples)
    assert np.max(np.abs(exact[-64:])) > 1e-3  # it still moves
    assert np.max(np.abs(found.displacement - exact)) < 2e-7


@pytest.mark.parametrize("effect", [e for e in LIBRARY if isinstance(e, ForceEffect)])
def test_every_force_is_proportional_to_its_strength(effect):
    function = effect.force or effect.friction
    z, inner = (0.003, 0.01), (0.4, 0.3, 0.2, 0.1, 0.05)
    for u, v in ((0.01, 0.2), (-0.6, -0.1), (0.5, -0.4)):
        once = function(0.7, u, v, z, (1.0, *inner))
        assert function(0.7, u, v, z, (3.0, *inner)) == pytest.approx(3.0 * once, rel=1e-12)
