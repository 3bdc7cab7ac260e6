"""Equivalent linearisation: the damping and the change of frequency by an effect, at every amplitude.

Along a harmonic motion u = A cos(w t) a small force f changes the amplitude as A' = -c_eq A / 2 and the frequency by
dw2 = change of w^2, with (first-order averaging, Krylov and Bogoliubov 1937)
    c_eq = <f v> / <v^2>,    dw2 = <f u> / <u^2>.
A force that is even in the displacement moves the centre and adds even harmonics, by which w^2 changes in second order.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, frozen
from identify.effects.compiled import STATES
from identify.effects.effect import Effect
from identify.effects.force_effect import ForceEffect

_POINTS = 512
_ANGLE = frozen(2.0 * np.pi * (np.arange(_POINTS + 1) + 0.5) / _POINTS)
_COSINE, _SINE = frozen(np.cos(_ANGLE)), frozen(np.sin(_ANGLE))


@dataclass(frozen=True, eq=False)
class Signature:
    """Equivalent viscous damping `damping` (1/s) and change of w^2 `stiffening` (1/s^2) at each amplitude, shape (n,).

    `mean` (m/s^2) is that of the force over a cycle. `settled` is False where the internal states did not become periodic.
    """

    damping: Array
    stiffening: Array
    mean: Array
    settled: bool


def average(
    effect: Effect,
    parameters: dict[str, float],
    frequency: float,
    amplitudes: Array,
    *,
    time: float = 0.0,
    second_order: bool = True,
) -> Signature:
    """Return the signature of one effect at `amplitudes` (n,) of a motion of angular `frequency` (rad/s).

    `parameters` holds its parameters, and those that it shares with other effects by "effect.parameter". What depends
    on time is taken at `time` s after the release. `second_order` False leaves out what even harmonics do to the
    frequency: it grows with the square of the strength, the rest in proportion. Raises ValueError for a sensor's fault,
    which is no force, and names a parameter that is missing.
    """
    if not isinstance(effect, ForceEffect):
        raise ValueError(f"{effect.name} is a fault of a sensor: it has no force, and so no signature")
    p = effect.table(parameters, parameters)
    damping, stiffening, mean = np.zeros((3, len(amplitudes)))
    settled = True
    for i, amplitude in enumerate(amplitudes):
        force, u, v, calm = _around(effect, p, frequency, float(amplitude), time)
        settled &= calm
        damping[i] = np.mean(force * v) / np.mean(v * v)
        stiffening[i] = np.mean(force * u) / np.mean(u * u)
        mean[i] = np.mean(force)
        if second_order and effect.force is not None and effect.rates is None:
            stiffening[i] += _second_order(effect, p, frequency, float(amplitude), time)
    return Signature(frozen(damping), frozen(stiffening), frozen(mean), settled)


def _harmonic(frequency: float, amplitude: float) -> tuple[Array, Array]:
    """Return displacement and velocity, (points + 1,) each, of one cycle.

    The points lie between the reversals, never on them, so that the sign of the velocity is never in doubt.
    """
    return amplitude * _COSINE, -amplitude * frequency * _SINE


def _around(
    effect: ForceEffect, p: tuple[float, ...], frequency: float, amplitude: float, time: float
) -> tuple[Array, Array, Array, bool]:
    """Return force, displacement and velocity (points,) once around, and whether the internal states are periodic."""
    u, v = _harmonic(frequency, amplitude)
    clock = time + (np.zeros(len(u)) if effect.rates is None else _ANGLE / frequency)
    start, size = effect.states_at_rest(amplitude, p), effect.state_sizes(amplitude, frequency)
    states, settled = effect.periodic_states(p, clock, u, v, start, size)
    clock, u, v = (values[:-1] for values in (clock, u, v))
    return effect.force_along(p, clock, u, v, states[:-1]), u, v, settled


def _second_order(
    effect: ForceEffect, p: tuple[float, ...], frequency: float, amplitude: float, time: float
) -> float:
    """Return the change of w^2 (1/s^2) by the even harmonics that a force of displacement adds to the motion.

    They answer the force as x = -f_0/w^2 + sum f_n cos(n theta) / ((n^2 - 1) w^2); the force along u + x is averaged
    again. For k2 u^2 this gives -5 k2^2 A^2 / (6 w^2) (Nayfeh and Mook 1979, 2.1).
    """
    theta = _ANGLE[:-1]
    u, v = (values[:-1] for values in _harmonic(frequency, amplitude))
    clock, states = np.full(len(theta), time), np.zeros((len(theta), STATES))

    def along(displacement: Array) -> Array:
        return effect.smooth_force_along(p, clock, displacement, v, states)

    straight = along(u)
    order = np.arange(2, 13, 2)
    parts = np.array([2.0 * np.mean(straight * np.cos(n * theta)) for n in order])
    waves = np.cos(np.outer(theta, order))
    answer = waves @ (parts / ((order**2 - 1.0) * frequency**2)) - float(np.mean(straight)) / frequency**2
    largest = float(np.max(np.abs(answer)))
    if largest < 1e-9 * amplitude:
        return 0.0
    share = min(1.0, 1e-3 * amplitude / largest)
    change = (along(u + share * answer) - along(u - share * answer)) / (2.0 * share)
    shape = np.cos(theta)
    return float(np.mean(change * shape) / np.mean(shape**2) / amplitude)


def force_over_cycle(
    effect: ForceEffect, parameters: dict[str, float], frequency: float, amplitude: float, time: float = 0.0
) -> Array:
    """Return the force (n,), m/s^2, of one effect over a cycle of a harmonic motion, at equal steps of its phase.

    Arguments as for `average`. Internal states are periodic; dry friction is on the side of the velocity.
    """
    p = effect.table(parameters, parameters)
    return _around(effect, p, frequency, amplitude, time)[0]
