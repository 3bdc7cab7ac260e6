"""Smoothing with the noise in view: the smoothest signal that stays within the noise of one channel."""

import numpy as np

from identify.algebra import solve_banded
from identify.arrays import Array, Mask

PENALTY_ORDER = 4
_RISE = 1.4
_DRIFTS = 0.75
"""Share of the misfit left by a corner 1.4 times as high: 0.43 for a jump in the acceleration, 0.84 for a random walk."""

_UNKNOWN = 1e-11
"""Weight of an unknown sample, over that of the penalty: without any a long gap cannot be solved."""

_PENALTY = np.array([1.0, -4.0, 6.0, -4.0, 1.0])
SLOPE = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
"""Central first derivative, exact to degree 6, per sample."""


def smooth(values: Array, corner: float, known: Mask | None = None) -> Array:
    """Return the penalised least-squares smooth of `values` (n,); `corner` is in cycles per sample.

    Fourth differences are penalised (Whittaker 1923): the gain at frequency f is 1 / (1 + (f/corner)^8), without phase,
    and polynomials of degree 3 pass unchanged, at the ends too. Unknown samples have hardly any weight.
    """
    n = len(values)
    if n < 10 or corner >= 0.4:
        return np.array(values, dtype=float)
    strength = (2.0 * np.sin(np.pi * corner)) ** -8
    band = np.zeros((PENALTY_ORDER + 1, n))
    for k in range(PENALTY_ORDER + 1):
        for m in range(PENALTY_ORDER + 1 - k):
            band[k, m : m + n - PENALTY_ORDER] += strength * _PENALTY[m] * _PENALTY[m + k]
    weights = np.ones(n) if known is None else np.where(known, 1.0, _UNKNOWN * strength)
    band[0] += weights
    return solve_banded(band, weights * values)


def gain_of(corner: float, fraction: Array) -> Array:
    """Return the gain of `smooth` with a corner at each frequency, both in cycles per sample."""
    ratio = np.sin(np.pi * fraction) / np.sin(np.pi * min(corner, 0.5))
    return np.asarray(1.0 / (1.0 + ratio**8))


def without_line(values: Array, known: Mask | None = None) -> Array:
    """Return `values` (n,) less the straight line through those that are known."""
    place = np.linspace(-1.0, 1.0, len(values))
    chosen = slice(None) if known is None else known
    line = np.polynomial.polynomial.polyfit(place[chosen], values[chosen], 1)
    return np.asarray(values - np.polynomial.polynomial.polyval(place, line))


def slope(values: Array, rate: float) -> Array:
    """Return the first derivative of a smooth signal, shape (n,); seven points inside, cubic at the ends."""
    n = len(values)
    result = np.empty(n)
    result[3:-3] = np.correlate(values, SLOPE, "valid")
    for end, piece in ((slice(0, 3), values[:5]), (slice(n - 3, n), values[-5:])):
        place = np.arange(3.0) if end.start == 0 else np.arange(2.0, 5.0)
        fit = np.polynomial.polynomial.polyfit(np.arange(5.0) - 2.0, piece, 4)
        result[end] = np.polynomial.polynomial.polyval(place - 2.0, np.polynomial.polynomial.polyder(fit))
    return result * rate


def smooth_to_noise(
    values: Array, noise: float, frequency: float, known: Mask, *, loud: bool = False
) -> tuple[Array, float]:
    """Return the smooth of `values` with the lowest corner that leaves no more than the noise, and that corner.

    `frequency` of the oscillation and the corner are in cycles per sample. The corner starts at five times the frequency,
    where the oscillation itself loses 3e-6, and rises until the misfit is the noise within four per cent, or hardly
    falls any more: a motion's harmonics fall quickly, if only as the jumps of dry friction do, a sensor drifts slowly.
    Of a `loud` channel it starts where the oscillation loses a tenth of the noise: closer by, noise is all that is added.
    """
    size = np.sqrt(2.0) * float(np.std(values[known]))
    corner = frequency * (min(5.0, max((10.0 * size / noise) ** 0.125, 1.5)) if loud else 5.0)
    smoothed = smooth(values, corner, known)
    misfit = _rms((values - smoothed)[known])
    while corner < 0.3 and misfit > 1.04 * noise:
        closer = smooth(values, _RISE * corner, known)
        left = _rms((values - closer)[known])
        if left > _DRIFTS * misfit:
            break
        corner, smoothed, misfit = _RISE * corner, closer, left
    return smoothed, min(corner, 0.5)


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
