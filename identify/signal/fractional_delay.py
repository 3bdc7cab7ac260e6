"""Fractional delay: read a sampled channel between its samples, without ringing at a jump."""

import numpy as np

from identify.arrays import Array, Mask

HALF_WIDTH = 3
"""Samples on either side of the nearest one that the interpolating polynomial passes through."""

_NODES = np.arange(-HALF_WIDTH, HALF_WIDTH + 1.0)
_STEP = 1e-30


def lagrange_weights(nodes: Array, places: Array) -> Array:
    """Return the weights of readings at `nodes` (k,) in the polynomial through them, read at `places` (m,), shape (k, m)."""
    others = [np.delete(nodes, i) for i in range(len(nodes))]
    return np.array(
        [np.prod((places[:, None] - o) / (node - o), axis=1) for node, o in zip(nodes, others, strict=True)]
    )


def lagrange_taps(fraction: float) -> Array:
    """Return weights that read a signal `fraction` of a sample after the centre one.

    `fraction` lies in [-0.5, 0.5]; weights multiply samples -HALF_WIDTH ... HALF_WIDTH. Lagrange
    interpolation is exact for polynomials of degree 2 HALF_WIDTH and, having finite support, cannot
    ring beyond it (Laakso et al., IEEE Signal Processing Magazine 13(1), 1996).
    """
    return lagrange_weights(_NODES, np.array([fraction]))[:, 0]


def lagrange_slope_taps(fraction: float) -> Array:
    """Return the derivative of `lagrange_taps` with respect to `fraction`, 1/sample.

    By a complex step (Squire and Trapp 1998), which subtracts nothing and so is exact for a polynomial.
    """
    return np.asarray(lagrange_weights(_NODES, np.array([fraction + 1j * _STEP]))[:, 0].imag / _STEP)


def split_shift(samples: float) -> tuple[int, float]:
    """Split a shift in samples into the nearest whole number and the rest in [-0.5, 0.5]."""
    whole = round(samples)
    return whole, samples - whole


def read_at_shift(values: Array, samples: float, valid: Mask | None = None) -> tuple[Array, Mask]:
    """Return `values` read `samples` later than each sample, shape (n,) of seven or more, and where that is known.

    Near the ends the polynomial goes through the last samples there are. Beyond the ends the last
    value is held and marked as not known; so is all that touches a lost sample with a weight above
    one per cent.
    """
    n = len(values)
    known = np.ones(n, dtype=bool) if valid is None else np.asarray(valid, dtype=bool)
    whole, fraction = split_shift(samples)
    centre = np.arange(n) + whole
    base = np.clip(centre, HALF_WIDTH, n - 1 - HALF_WIDTH)
    filled = bridge(values, known)
    result = np.zeros(n)
    doubt = np.zeros(n)
    for offset, weight in zip(range(-HALF_WIDTH, HALF_WIDTH + 1), lagrange_taps(fraction), strict=True):
        result += weight * filled[base + offset]
        doubt += abs(weight) * ~known[base + offset]
    for i in np.flatnonzero(base != centre):
        position = centre[i] + fraction
        if 0 <= position <= n - 1:
            result[i], doubt[i] = _read_near_end(filled, known, float(position))
        else:
            result[i], doubt[i] = filled[0 if position < 0 else n - 1], 1.0
    return result, doubt < 0.01


def bridge(values: Array, known: Mask) -> Array:
    """Return `values` with straight lines across the samples that are not known."""
    if bool(known.all()):
        return np.asarray(values, dtype=float)
    index = np.arange(len(values))
    if not bool(known.any()):
        return np.zeros(len(values))
    return np.interp(index, index[known], np.asarray(values)[known])


def _read_near_end(values: Array, known: Mask, position: float) -> tuple[float, float]:
    """Cubic through the four samples nearest to `position`: the long polynomial would amplify noise there."""
    first = int(np.clip(np.floor(position) - 1, 0, len(values) - 4))
    weights = lagrange_weights(np.arange(first, first + 4.0), np.array([position]))[:, 0]
    window = slice(first, first + 4)
    return float(weights @ values[window]), float(np.abs(weights) @ ~known[window])
