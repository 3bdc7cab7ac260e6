"""Integration with the low frequencies removed, the ends treated: what the paper did with its accelerometer."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline

from identify.arrays import Array, Mask
from identify.signal.kinematics import AVERAGES

DEGREE = 3
"""Degree of the splines: what twice-integrated noise asks for, and little freedom at the ends."""


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
    """Return what drifts under an oscillation at `frequency` (Hz), found beside the oscillation, not by filtering it.

    Least squares of `values` on splines of one knot in two periods, together with the same splines times cosine
    and sine. The oscillation has its own terms, so neither its start nor its decay leaks into the slow part:
    a filter would do most harm at the release, where the amplitude is largest.
    """
    time = np.arange(len(values)) / rate
    end = float(time[-1])
    spans = max(1, round(end * frequency / 2.0))
    knots = np.concatenate([[0.0] * DEGREE, np.linspace(0.0, end, spans + 1), [end] * DEGREE])
    step = max(1, int(rate / (POINTS_PER_PERIOD * frequency)))
    rows = np.flatnonzero(weights)[::step]
    splines = BSpline.design_matrix(np.clip(time[rows], 0.0, end), knots, DEGREE).toarray()
    phase = 2.0 * np.pi * frequency * time[rows]
    design = np.hstack([splines, splines * np.cos(phase)[:, None], splines * np.sin(phase)[:, None]])
    coefficients = np.linalg.lstsq(design, values[rows], rcond=1e-10)[0][: splines.shape[1]]
    spline = BSpline(knots, coefficients, DEGREE)
    return Slow(spline(time), spline.derivative(1)(time), spline.derivative(2)(time))
