"""A mass that a recorded force drives on: no free decay, but the same question."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from specimens import diagnosed

from identify.comparison.compare import compare_fitted
from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay, prepare

RATE, MASS, K, MU_1 = 256.0, 2.5, 620.0, 1.1
NOISE = 5e-6


class Lines:
    """A force of forty lines of 2 N from 1 to 10 Hz, and what a linear oscillator does under it."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng(seed)
        self.omega = 2 * np.pi * random.uniform(1.0, 10.0, 40)
        self.amplitude = 2.0 * np.exp(1j * random.uniform(0.0, 2 * np.pi, 40))

    def force(self, time: np.ndarray | float) -> np.ndarray:
        return self._sum(time, self.amplitude)

    def steady_motion(self, time: np.ndarray) -> np.ndarray:
        return self._sum(time, self.amplitude / MASS / (K - self.omega**2 + 1j * MU_1 * self.omega))

    def _sum(self, time: np.ndarray | float, amplitude: np.ndarray) -> np.ndarray:
        return (np.exp(1j * np.multiply.outer(time, self.omega)) * amplitude).sum(axis=-1).imag


def clock(seconds: float) -> np.ndarray:
    return np.arange(int(seconds * RATE)) / RATE


def recorded(motion: np.ndarray, force: np.ndarray, mass: float | None = None) -> PreparedDecay:
    noise = NOISE * np.random.default_rng(0).standard_normal(len(motion))
    decay = FreeDecay(RATE, displacement=motion + noise, force=force, mass=mass)
    return prepare(decay)


def linear(seed: int, seconds: float = 8.0, mass: float | None = None) -> PreparedDecay:
    time, lines = clock(seconds), Lines(seed)
    return recorded(lines.steady_motion(time), lines.force(time) / (mass or 1.0), mass)


@pytest.mark.slow
def test_a_driven_duffing_oscillator_asks_for_its_cubic_spring_and_for_no_friction():
    time, lines, cubic = clock(6.0), Lines(3), 9e4

    def rates(t: float, y: np.ndarray) -> list[float]:
        return [y[1], float(lines.force(t)) / MASS - K * y[0] - MU_1 * y[1] - cubic * y[0] ** 3]

    motion = solve_ivp(
        rates, (0.0, time[-1]), [0.01, 0.0], "DOP853", t_eval=time, rtol=1e-9, atol=1e-11, max_step=0.02
    ).y[0]
    found = diagnosed(recorded(motion, lines.force(time)))
    assert found.named == ("cubic_stiffness",)
    estimate = found.final.values["cubic_stiffness.k3"]
    assert abs(estimate.value - cubic) < 4.0 * estimate.std
    friction = found.final.values["coulomb_friction.mu_0"]
    assert friction.value < 4.0 * min(friction.std, 1e-3)  # at the bound of nil there is no error


def test_a_driven_linear_oscillator_lacks_nothing():
    tried = (
        "cubic_stiffness",
        "quadratic_damping",
        "stribeck_friction",
        "second_mass",
        "channel_lag",
        "offset_drift",
    )
    library = tuple(find_effect(name) for name in tried)
    assert diagnose((linear(4, mass=MASS),), library=library).verdict == "nothing_missing"


def test_the_mass_behind_a_force_is_found():
    prepared = linear(5)
    force = prepared.window.force
    assert force is not None
    gain = fit_baseline((prepared,), base_model()).fit.values["force_gain"]
    first_guess = float(np.median(force / Lines(5).force(prepared.window.clock)))
    assert abs(gain.value * first_guess - 1.0 / MASS) < 4.0 * gain.std * first_guess
    assert gain.std < 1e-3


def test_the_force_error_of_a_driven_record_counts_the_force_in():
    prepared = linear(6)
    start = fit_baseline((prepared,), base_model())
    found = compare_fitted(start)
    assert found.force_error < 0.05  # %; inertia alone would leave some 50
    assert 0.9 < start.fit.reduced < 1.1


def test_a_long_driven_record_is_judged_by_its_liveliest_stretch():
    time, lines = clock(40.0), Lines(7)
    swell = np.exp(-(((time - 25.0) / 12.0) ** 2))  # slow beside the motion
    prepared = recorded(swell * lines.steady_motion(time), swell * lines.force(time))
    assert 10.0 < prepared.window.clock[0] < 25.0 < prepared.window.clock[-1] < 40.0
    assert len(prepared.window) < len(time)
