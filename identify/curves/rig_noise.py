"""Disturbances of a rig's curves besides laws: noise of overlapping windows, random walks, a law outside the library."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from identify.arrays import Array
from identify.curves.curve_laws import summed
from identify.curves.decay_curve import DecayCurve
from identify.curves.isolated_mode import IsolatedMode
from identify.priors import BENDS_OVER, LEAKS

CENTRE = 2
"""Channel of the centre; 0 is the logarithm of the amplitude, 1 the phase."""

_OVERLAPS = 5
"""Windows on either side that may share readings with one."""

_ALONE = 0.02
"""Share of a window's error that no other window shares, so that the noise can be inverted."""


DRIFT = 0.04
"""Variance of the drift from one point to the next over that of the scatter: slow forces drift too."""


@dataclass(frozen=True, eq=False)
class RigNoise:
    """The disturbances of one curve: `overlap` (n, n) correlates the errors of windows; `frequency` in rad/s."""

    curve: DecayCurve
    overlap: Array
    frequency: float

    @cached_property
    def walks(self) -> tuple[Array, Array, Array]:
        """Covariances (n, n) that random walks of damper, spring and centre give the channels."""
        time = self.curve.time - self.curve.time[0]
        early, late = np.minimum(time[:, None], time), np.maximum(time[:, None], time)
        walk = (
            0.25 * self.frequency**3 * early**2 * (3.0 * late - early) / 6.0
        )  # an integrated Wiener process
        return walk, walk, self.frequency * early

    def covariance(self, channel: int, noise: Sequence[float], walk: float) -> Array:
        """Return the covariance of a channel under noise and a walk of some size, (n, n).

        `noise` is relative to the amplitude for each channel (to the largest for the centre), and last absolute.
        """
        size = self.curve.amplitude
        unit = size if channel != CENTRE else np.full(len(size), size.max())
        absolute, misfit = noise[-1] / unit, LEAKS[channel] * self.curve.misfit * size / unit
        own = noise[channel] ** 2 + np.outer(absolute, absolute) + np.outer(misfit, misfit)
        return np.asarray(self.overlap * own + walk**2 * self.walks[channel])

    def drifting(self, channel: int, scatter: float) -> Array:
        """Return the covariance of a residual that scatters (m or rad) and drifts from point to point, (n, n)."""
        size = self.curve.amplitude
        unit = size if channel != CENTRE else np.full(len(size), size.max())
        drift = DRIFT * np.cumsum(unit**-2.0)
        return np.asarray(
            scatter**2 * (self.overlap / np.outer(unit, unit) + np.minimum(drift[:, None], drift))
        )

    def nameless(self, grid: Array, shapes: Array) -> tuple[Array, Array, Array]:
        """Return the effect, (n, m), on each channel of nameless laws: `shapes` (k, m) over log amplitudes `grid` (k,)."""
        curve = self.curve
        between, at = (
            np.column_stack([np.interp(np.log(size), grid, shape) for shape in shapes.T])
            for size in (curve.between, curve.amplitude)
        )
        law = 0.5 * self.frequency * summed(between, curve)
        return law, law, at * (curve.amplitude / curve.amplitude.max())[:, None]


def nameless_shapes(curves: Sequence[DecayCurve]) -> tuple[Array, Array]:
    """Return log amplitudes (k,) and random smooth functions of them (k, m): their sum with normal numbers is the law."""
    size = np.log(np.concatenate([curve.amplitude for curve in curves]))
    span = float(np.ptp(size))
    grid = np.linspace(size.min(), size.max(), 8 + int(4.0 * span / BENDS_OVER))
    covariance = np.exp(-0.5 * ((grid[:, None] - grid) / BENDS_OVER) ** 2)
    power, shapes = np.linalg.eigh(covariance)
    kept = power > 1e-3 * power[-1]
    return grid, np.asarray(shapes[:, kept] * np.sqrt(power[kept]))


def overlap_of(mode: IsolatedMode) -> Array:
    """Return the correlation of the errors of all windows, which share readings with their neighbours, (n, n)."""
    waves = [operator[0] + 1j * operator[1] for operator in mode.windows.operators]
    waves = [wave / np.sqrt(np.sum(np.abs(wave) ** 2)) for wave in waves]
    count = len(waves)
    shared = np.eye(count, dtype=complex)
    for i in range(count):
        for j in range(i + 1, min(i + 1 + _OVERLAPS, count)):
            apart = int(mode.windows.first[j] - mode.windows.first[i])
            common = min(len(waves[i]) - apart, len(waves[j]))
            if common <= 0:
                break
            shared[i, j] = np.sum(waves[i][apart : apart + common] * np.conj(waves[j][:common]))
            shared[j, i] = np.conj(shared[i, j])
    turned = np.exp(
        -1j * np.concatenate([[0.0], np.cumsum(np.angle(np.diag(shared, 1)))])
    )  # along the motion
    along = np.real(np.conj(turned)[:, None] * shared * turned[None, :])
    return np.asarray((1.0 - _ALONE) * along + _ALONE * np.eye(count))
