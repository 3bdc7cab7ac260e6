"""The envelope and the phase of a decay, fitted by the averaged equations (9)-(12)."""

import numpy as np

from identify.arrays import Array


def cumulative(values: Array, step: float) -> Array:
    """Return the running trapezoidal integral of `values` along the last axis, from zero, the same shape."""
    out = np.zeros_like(values)
    np.cumsum(0.5 * step * (values[..., 1:] + values[..., :-1]), axis=-1, out=out[..., 1:])
    return out


def solve_integrated(envelope: Array, step: float, order: int, weight: Array) -> Array:
    """Return k(0), c_0..c_order from eqs. (10)-(12), the integrated envelope equation, by least squares.

    k(t) - k(0) = -sum c_i int k^i: `envelope` (m,) at `step` s. k(0) is left free, so that no single
    noisy sample carries the whole fit.
    """
    scale = float(np.max(envelope))
    relative = envelope / scale
    powers = np.stack([relative**i for i in range(order + 1)])
    found = _weighted([np.ones(len(envelope)), *-cumulative(powers, step)], relative, weight)
    found *= scale
    found[1:] /= scale ** np.arange(order + 1)
    return found


def fit_phase(phase: Array, envelope: Array, step: float, orders: tuple[int, ...], weight: Array) -> Array:
    """Fit phi(0) + sum d_i int k^(i-1) dt over the odd `orders` to `phase` (m,), weighted by the envelope.

    The backbone w = d_1 + d_3 k^2 + d_5 k^4 integrated in time, as eq. (10) integrates the envelope.
    The phase's noise is the sample's over the envelope, hence the weight. Returns phi(0), d_1, d_3 ....
    """
    scale = float(np.max(envelope))
    powers = np.stack([(envelope / scale) ** (i - 1) for i in orders])
    columns = [np.ones(len(phase)), *cumulative(powers, step)]
    found = _weighted(columns, phase - phase[0], envelope * weight)
    found[1:] /= scale ** (np.array(orders) - 1.0)
    found[0] += phase[0]
    return found


def _weighted(columns: list[Array], values: Array, weight: Array) -> Array:
    """Return the coefficients (p,) of weighted least squares; the least ones where two columns are one."""
    design = np.column_stack(columns) * weight[:, None]
    size = np.linalg.norm(design, axis=0) + 1e-300
    return np.asarray(np.linalg.lstsq(design / size, values * weight, rcond=1e-7)[0] / size)


def phase_model(parameters: Array, envelope: Array, step: float, orders: tuple[int, ...]) -> Array:
    """Return phi(0) + sum d_i int k^(i-1) dt at the points of `envelope` (m,)."""
    slopes = np.zeros(len(envelope))
    for order, slope in zip(orders, parameters[1:], strict=True):
        slopes += slope * envelope ** (order - 1)
    return np.asarray(parameters[0] + cumulative(slopes, step))
