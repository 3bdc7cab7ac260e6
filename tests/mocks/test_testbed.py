"""The testbed against closed forms."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipk

from mocks.forces import Effect
from mocks.testbed import Bench, Release, simulate, simulate_channels

STIFFNESS = 613.7
W0 = math.sqrt(STIFFNESS)
#: RK4 with a quarter of a millisecond leaves some 1e-11 m; a hundred times that.
EXACT_M = 1e-9


def test_each_cycle_loses_four_times_the_friction_over_the_stiffness_without_viscous_friction():
    friction = 0.13
    bench = Bench(STIFFNESS, friction, 0.0)
    turns = np.arange(40) * math.pi / W0  # Friction does not change the half period.
    motion = simulate(bench, Release(0.025), turns)
    expected = 0.025 - np.arange(40) * 2.0 * friction / STIFFNESS
    np.testing.assert_allclose(np.abs(motion.displacement), expected, atol=EXACT_M)
    whole = motion.displacement[::2]
    np.testing.assert_allclose(-np.diff(whole), 4.0 * friction / STIFFNESS, atol=EXACT_M)


@pytest.mark.parametrize("start", [0.025, -0.0183, 0.0071])
def test_the_mass_comes_to_rest_where_the_last_half_cycle_leaves_it(start):
    friction = 0.1317
    reach = friction / STIFFNESS
    amplitude, side = abs(start), math.copysign(1.0, start)
    while amplitude > reach:
        amplitude, side = amplitude - 2.0 * reach, -side  # Negative: it stops before the middle.
    motion = simulate(Bench(STIFFNESS, friction, 0.0), Release(start), np.array([30.0, 31.0]))
    np.testing.assert_allclose(motion.displacement, side * amplitude, atol=EXACT_M)
    assert abs(motion.displacement[0]) <= reach
    assert motion.velocity[0] == 0.0
    assert motion.acceleration[0] == 0.0


def test_a_mass_let_go_inside_the_friction_does_not_move():
    motion = simulate(Bench(STIFFNESS, 0.13, 0.277), Release(0.99 * 0.13 / STIFFNESS), np.linspace(0, 5, 99))
    assert np.all(motion.displacement == 0.99 * 0.13 / STIFFNESS)


def test_the_decay_is_the_textbook_exponential_without_dry_friction():
    mu_1 = 0.3
    time = np.linspace(0.0, 8.0, 4001)
    motion = simulate(Bench(STIFFNESS, 0.0, mu_1), Release(0.02), time)
    w = math.sqrt(STIFFNESS - mu_1**2 / 4.0)
    decay = np.exp(-mu_1 * time / 2.0)
    u = 0.02 * decay * (np.cos(w * time) + mu_1 / (2.0 * w) * np.sin(w * time))
    v = -0.02 * decay * STIFFNESS / w * np.sin(w * time)
    np.testing.assert_allclose(motion.displacement, u, atol=EXACT_M)
    np.testing.assert_allclose(motion.velocity, v, atol=EXACT_M * W0)
    np.testing.assert_allclose(motion.acceleration, -STIFFNESS * u - mu_1 * v, atol=EXACT_M * STIFFNESS)


def test_an_initial_velocity_starts_a_damped_sine():
    mu_1 = 0.3
    time = np.linspace(0.0, 8.0, 997)
    motion = simulate(Bench(STIFFNESS, 0.0, mu_1), Release(0.0, -0.5), time)
    w = math.sqrt(STIFFNESS - mu_1**2 / 4.0)
    expected = -0.5 / w * np.exp(-mu_1 * time / 2.0) * np.sin(w * time)
    np.testing.assert_allclose(motion.displacement, expected, atol=EXACT_M)


@pytest.mark.parametrize("hardening", [2e5, -2e5])
def test_the_period_with_a_cubic_spring_is_duffings(hardening):
    amplitude = 0.024
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("cubic_stiffness", {"k3": hardening}),))
    added = hardening * amplitude**2
    if hardening > 0.0:  # A cn, with the parameter m (not the modulus) of scipy.
        period = 4.0 / math.sqrt(STIFFNESS + added) * ellipk(added / (2.0 * (STIFFNESS + added)))
    else:  # A sn
        period = 4.0 / math.sqrt(STIFFNESS + added / 2.0) * ellipk(-added / (2.0 * STIFFNESS + added))
    motion = simulate(bench, Release(amplitude), np.array([period, 20.0 * period]))
    np.testing.assert_allclose(motion.displacement, amplitude, atol=EXACT_M)
    # The velocity at a turning point tells the period: 1e-9 m/s over a = 15 m/s^2 is below 1e-9 s.
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-8)


def test_a_bilinear_spring_has_the_period_of_its_two_halves():
    more = 150.0
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("bilinear_stiffness", {"kb": more}),))
    period = sum(math.pi / math.sqrt(STIFFNESS + side * more / 2.0) for side in (-1.0, 1.0))
    motion = simulate(bench, Release(0.02), np.array([17.0 * period]))
    np.testing.assert_allclose(motion.displacement, 0.02, atol=EXACT_M)


def test_an_end_stop_turns_the_mass_as_its_energy_says():
    stop, gap, start = 900.0, 0.012, -0.02
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("end_stop", {"ks": stop, "gap": gap, "side": 1.0}),))
    motion = simulate(bench, Release(start), np.linspace(0.0, 1.0, 200001))
    # k A^2 = k x^2 + ks (x - gap)^2
    a, b, c = STIFFNESS + stop, -2.0 * stop * gap, stop * gap**2 - STIFFNESS * start**2
    furthest = (-b + math.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    # The grid of 5 us misses the turning point by a t^2 / 8 = 1e-10 m at most.
    assert motion.displacement.max() == pytest.approx(furthest, abs=EXACT_M)


def test_a_spring_that_hardens_with_its_deflection_has_the_period_of_its_energy():
    more, amplitude = 3000.0, 0.02
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("signed_quadratic_stiffness", {"k2a": more}),))

    def slowness(angle):  # dt/d(angle) for u = A sin(angle), from v^2 = k (A^2 - u^2) + 2/3 k2a (A^3 - u^3)
        x = np.sin(angle)
        return 1.0 / np.sqrt(STIFFNESS + 2.0 / 3.0 * more * amplitude * (1.0 + x + x * x) / (1.0 + x))

    period = 4.0 * quad(slowness, 0.0, np.pi / 2.0, epsabs=1e-13)[0]
    motion = simulate(bench, Release(amplitude), np.array([period, 20.0 * period]))
    np.testing.assert_allclose(motion.displacement, amplitude, atol=EXACT_M)


def test_a_stop_with_loss_gives_back_the_speed_of_its_closed_form():
    """v dv/(1 + loss v) = -ks d dd on the way in and out (Hunt and Crossley 1975, with a linear stop)."""
    stop, gap, loss, speed = 4e4, 0.005, 1.7, 0.3
    stopped = Effect("impact_with_loss", {"ks": stop, "gap": gap, "side": 1.0, "loss": loss})
    motion = simulate(Bench(1e-9, 0.0, 0.0, (stopped,)), Release(0.0, speed), np.array([0.1]))

    def level(v):
        return v / loss - math.log(1.0 + loss * v) / loss**2

    back = brentq(lambda v: level(-v) - level(speed), 1e-6, speed)
    assert motion.velocity[0] == pytest.approx(-back, rel=1e-6)
    assert back == pytest.approx(speed * (1.0 - 2.0 / 3.0 * loss * speed), rel=0.15)  # its rule of thumb


def test_friction_before_sliding_rises_to_its_level_over_its_length():
    over, start, kd = 0.002, 0.02, 40.0
    asperity = {"kd": kd, "ud": over, "z_start": over}
    time = np.linspace(0.0, 0.1, 50)
    motion = simulate(Bench(STIFFNESS, 0.0, 0.0, (Effect("dahl_friction", asperity),)), Release(start), time)
    # On the way down dz/du = 1 + z/ud (Dahl 1968).
    expected = kd * (-over + 2.0 * over * np.exp((motion.displacement - start) / over))
    assert motion.velocity[1:].max() < 0.0
    np.testing.assert_allclose(motion.effects[0], expected, atol=1e-9)
    smooth = Effect("lugre_friction", asperity | {"rise": 0.0, "vs": 0.1})
    other = simulate(Bench(STIFFNESS, 0.0, 0.0, (smooth,)), Release(start), time)
    np.testing.assert_array_equal(other.displacement, motion.displacement)


def test_a_stiffness_that_settles_is_integrated_as_another_integrator_does():
    r, tau, time = 0.05, 0.7, np.linspace(0.0, 4.0, 300)
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("settling_stiffness", {"r": r, "tau": tau}),))

    def slope(t, y):
        return [y[1], -STIFFNESS * (1.0 + r * (1.0 - math.exp(-t / tau))) * y[0]]

    exact = solve_ivp(slope, (0.0, 4.0), [0.02, 0.0], t_eval=time, rtol=1e-12, atol=1e-14, method="DOP853")
    np.testing.assert_allclose(simulate(bench, Release(0.02), time).displacement, exact.y[0], atol=EXACT_M)


def test_a_second_mass_without_damping_keeps_the_energy_of_both():
    ratio, w2 = 0.03, 80.0
    bench = Bench(STIFFNESS, 0.0, 0.0, (Effect("second_mass", {"ratio": ratio, "w2": w2, "zeta": 0.0}),))
    time = np.linspace(0.0, 8.0, 3001)
    motion = simulate(bench, Release(0.02), time)
    # Two modes of u'' = -k u - ratio w2^2 (u - y), y'' = w2^2 (u - y), from u = y = A at rest.
    matrix = np.array([[STIFFNESS + ratio * w2**2, -ratio * w2**2], [-(w2**2), w2**2]])
    squares, modes = np.linalg.eig(matrix)
    parts = np.linalg.solve(modes, np.array([0.02, 0.02]))
    expected = sum(modes[0, i] * parts[i] * np.cos(math.sqrt(squares[i]) * time) for i in (0, 1))
    # RK4's error of the second mode, 600 radians on: (w h)^4 / 120 per radian, 1e-6 of its part.
    np.testing.assert_allclose(motion.displacement, expected, atol=3e-9)


def test_a_maxwell_element_decays_as_its_cubic_says():
    k1, tau = 40.0, 0.03
    bench = Bench(STIFFNESS, 0.0, 0.2, (Effect("maxwell_element", {"k1": k1, "tau": tau}),))
    time = np.linspace(0.0, 4.0, 777)
    matrix = np.array([[0.0, 1.0, 0.0], [-STIFFNESS - k1, -0.2, k1], [1.0 / tau, 0.0, -1.0 / tau]])
    roots, shapes = np.linalg.eig(matrix)
    parts = np.linalg.solve(shapes, np.array([0.02, 0.0, 0.02], dtype=complex))
    expected = np.real(sum(shapes[0, i] * parts[i] * np.exp(roots[i] * time) for i in range(3)))
    np.testing.assert_allclose(simulate(bench, Release(0.02), time).displacement, expected, atol=EXACT_M)


def test_forcing_far_from_resonance_adds_the_particular_solution():
    force, frequency = 0.1, 12.3
    bench = Bench(
        STIFFNESS, 0.0, 3.0, (Effect("harmonic_forcing", {"amp": force, "f": frequency, "phase": 0.7}),)
    )
    time = np.linspace(19.0, 20.0, 500)  # The free part has fallen to e^-30.
    w = 2.0 * math.pi * frequency
    answer = force / (STIFFNESS - w * w + 3.0j * w)
    expected = np.imag(answer * np.exp(1j * (w * time + 0.7)))
    # (w h)^4 / 120 of the answer is 1e-6 of it, 2e-11 m; e^-28 of 2 cm is 1e-14 m.
    np.testing.assert_allclose(simulate(bench, Release(0.02), time).displacement, expected, atol=EXACT_M)


def test_hysteresis_that_has_not_slipped_far_is_a_spring_and_far_out_a_constant():
    time = np.linspace(0.0, 0.05, 200)
    wide = Bench(STIFFNESS, 0.0, 0.0, (Effect("hysteresis", {"kh": 30.0, "uy": 1e3, "z_start": 0.02}),))
    expected = 0.02 * np.cos(math.sqrt(STIFFNESS + 30.0) * time)
    np.testing.assert_allclose(simulate(wide, Release(0.02), time).displacement, expected, atol=EXACT_M)
    narrow = Bench(STIFFNESS, 0.0, 0.0, (Effect("hysteresis", {"kh": 600.0, "uy": 5e-4, "z_start": 0.0}),))
    motion = simulate(narrow, Release(0.02), np.array([0.04]))
    assert 0.02 - motion.displacement[0] > 10.0 * 5e-4
    # kh uy along the motion; 1 - tanh(10) is 4e-9.
    assert motion.effects[0, 0] == pytest.approx(-0.3, rel=1e-6)


def test_energy_is_lost_to_friction_and_to_nothing_else():
    bench = Bench(STIFFNESS, 0.13, 0.277)
    time = np.linspace(0.0, 3.0, 300001)
    motion = simulate(bench, Release(0.025), time)
    energy = 0.5 * motion.velocity**2 + 0.5 * STIFFNESS * motion.displacement**2
    power = 0.277 * motion.velocity**2 + 0.13 * np.abs(motion.velocity)
    lost = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1])) * (time[1] - time[0])])
    # The trapezium with 10 us steps errs by h^2 / 12 times the slope of the power: 1e-9 of the energy.
    np.testing.assert_allclose(energy + lost, energy[0], atol=1e-9 * energy[0] + 2e-10)


def test_the_late_channel_is_the_early_one_shifted_exactly():
    bench = Bench(STIFFNESS, 0.13, 0.277)
    lag = 0.0012345
    grid = np.arange(-50, 1500) / 256.0
    late, _ = simulate_channels(bench, Release(0.02, release_time=0.007), grid - lag, grid)
    shifted = simulate(bench, Release(0.02, release_time=0.007), grid - lag).displacement
    np.testing.assert_allclose(late, shifted, atol=EXACT_M)


def test_a_release_that_takes_its_time_never_moves_the_mass_before_it_begins():
    time = np.sort(np.concatenate([np.linspace(-1.0, 0.0, 500, endpoint=False), np.linspace(0.0, 0.02, 401)]))
    motion = simulate(Bench(STIFFNESS, 0.13, 0.277), Release(-0.02, release_time=0.02), time)
    assert np.all(motion.displacement[time <= 0.0] == -0.02)
    assert np.all(motion.acceleration[time <= 0.0] == 0.0)
    # It breaks loose when the holding force has fallen by the friction: k A (1 - cos) / 2 = mu_0.
    free = 0.02 / math.pi * math.acos(1.0 - 2.0 * 0.13 / (STIFFNESS * 0.02))
    assert np.all(motion.displacement[time < free] == -0.02)
    moving = time > free + 1e-4
    assert np.all(motion.displacement[moving] > -0.02)
    assert np.all(np.diff(motion.displacement[moving]) > 0.0)


def test_a_slow_release_leaves_the_mass_where_the_ideal_one_does_half_its_time_later():
    bench = Bench(STIFFNESS, 0.0, 0.0)
    grid = np.linspace(0.5, 1.0, 301)
    slow = simulate(bench, Release(0.02, release_time=0.004), grid).displacement
    ideal = simulate(bench, Release(0.02), grid - 0.002).displacement
    # A symmetric ramp of length T delays by T/2; what is left is of the order (w T)^2 / 24 of A.
    assert np.max(np.abs(slow - ideal)) < 0.02 * (W0 * 0.004) ** 2 / 12.0


def test_a_push_gives_the_velocity_asked_for():
    bench = Bench(1e-6, 0.0, 0.0)
    motion = simulate(bench, Release(0.0, 0.4, 0.01), np.array([0.01, 0.02]))
    np.testing.assert_allclose(motion.velocity, 0.4, atol=1e-9)
    assert motion.displacement[0] == pytest.approx(0.4 * 0.005, abs=1e-9)
