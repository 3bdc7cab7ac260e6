"""Integration with the low frequencies removed, the ends treated: what the paper did with its accelerometer."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identify.algebra import solve_banded
from identify.arrays import Array, Mask
from identify.signal.kinematics import AVERAGES
from identify.signal.splines import DEGREE, basis

_RIDGE = 1e-11
"""Added to the normal equations, whose diagonal is one, so that stretches without samples can be solved for."""

POINTS_PER_PERIOD = 48
"""The slow part of a faster recording is found from about this many samples a period."""


class Slow(NamedTuple):
    """The slow part of an integral and its first two derivatives, each of shape (n,)."""

    value: Array
    first: Array
    second: Array


def integrate(values: Array, rate: float, excess: Array | None = None) -> Array:
    """Return the integral of `values` (n,) from the first sample, exact for polynomials of degree 5 inside."""
    first, taps = AVERAGES[1]
    steps = 0.5 * (values[1:] + values[:-1])
    inner = np.correlate(values, taps, "valid")
    steps[-first : -first + len(inner)] = inner
    if excess is not None:
        steps -= excess[:-1]
    return np.concatenate([[0.0], np.cumsum(steps)]) / rate


def slow_part(values: Array, rate: float, frequency: float, weights: Mask) -> Slow:
    """Estimate the drift under an oscillation at `frequency` (Hz), by a fit of both, not by filtering.

    Least squares of `values` on splines of one knot in two periods, together with the same splines times cosine
    and sine. The oscillation has its own terms, so neither its start nor its decay leaks into the slow part:
    a filter would do most harm at the release, where the amplitude is largest. Each sample sees only the splines over
    it, so the normal equations are banded: time and memory grow with the length, not with its square.
    """
    time = np.arange(len(values)) / rate
    end = float(time[-1])
    spans = max(1, round(end * frequency / 2.0))
    step = max(1, int(rate / (POINTS_PER_PERIOD * frequency)))
    rows = np.flatnonzero(weights)[::step]
    first, weight = basis(time[rows], 0.0, end, spans)
    over = first[:, None] + np.arange(DEGREE + 1)
    phase = 2.0 * np.pi * frequency * time[rows]
    waves = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=1)
    # the three columns of a spline stand side by side
    design = (weight[:, :, None] * waves[:, None, :]).reshape(len(rows), -1)
    place = (3 * over[:, :, None] + np.arange(3)).reshape(len(rows), -1)
    slow = _banded_least_squares(design, place, values[rows], 3 * (spans + DEGREE))[::3]
    parts = []
    for derivative in range(3):
        first, weight = basis(time, 0.0, end, spans, derivative)
        parts.append(np.sum(weight * slow[first[:, None] + np.arange(DEGREE + 1)], axis=1))
    return Slow(*parts)


def _banded_least_squares(design: Array, place: NDArray[np.int_], values: Array, columns: int) -> Array:
    """Return the least squares solution (columns,) of rows that touch a few neighbouring columns each.

    `design` (n, m) holds the entries of a row, `place` (n, m) their columns, ascending and without a gap. Columns that
    no row touches come out zero. The normal equations square the condition; a second pass on what the first one
    left makes up for it.
    """
    size = np.sqrt(np.bincount(place.ravel(), (design**2).ravel(), columns))
    size[size == 0.0] = 1.0
    design = design / size[place]
    width = design.shape[1]
    band = np.zeros((width, columns))
    for offset in range(width):
        products = (design[:, offset:] * design[:, : width - offset]).ravel()
        band[offset] = np.bincount(place[:, : width - offset].ravel(), products, columns)
    band[0] += _RIDGE
    found, left = np.zeros(columns), values
    for _ in range(2):
        right = np.bincount(place.ravel(), (design * left[:, None]).ravel(), columns)
        found += solve_banded(band, right.astype(np.float64))
        left = values - np.sum(design * found[place], axis=1)
    return np.asarray(found / size)
