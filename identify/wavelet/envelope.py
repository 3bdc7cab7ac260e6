"""The envelope and the phase of a decay, fitted by the averaged equations (9)-(12)."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.signal.averaging import integrate_envelope


@dataclass(frozen=True, eq=False)
class PhaseFit:
    """phi(0), w_1 and the slopes with k^2, k^4 of the phase, with what carries noise of the phase into them.

    `parameters` (p,); `fit` (m,) the phase that they give; `gain` (p, m) the change of the parameters for a change of each
    of its samples.
    """

    parameters: Array
    fit: Array
    gain: Array


@dataclass(frozen=True, eq=False)
class EnvelopeFit(PhaseFit):
    """k(0) and c_0..c_n of k' = -sum c_i k^i, likewise; `mse_percent` is the misfit over the variance, as in eq. (18)."""

    mse_percent: float


def cumulative(values: Array, step: float) -> Array:
    """Return the running trapezoidal integral of `values` along the last axis, from zero, the same shape."""
    out = np.zeros_like(values)
    np.cumsum(0.5 * step * (values[..., 1:] + values[..., :-1]), axis=-1, out=out[..., 1:])
    return out


def weighted_inverse(rows: Array, weight: Array) -> Array:
    """Return the least-squares inverse (p, m) of p functions of m points, `rows` (p, m), with `weight` (m,)."""
    weighted = rows * weight
    size = np.linalg.norm(weighted, axis=1)[:, None] + 1e-300
    unit = weighted / size
    normal = unit @ unit.T
    normal[np.diag_indices(len(normal))] += 1e-13  # solvable even where two functions are one
    return np.asarray(np.linalg.solve(normal, unit) * weight / size)


def solve_integrated(envelope: Array, step: float, order: int, weight: Array) -> Array:
    """Return k(0), c_0..c_order from eqs. (10)-(12), the integrated envelope equation, by least squares.

    k(t) - k(0) = -sum c_i int k^i: `envelope` (m,) at `step` s. k(0) is left free, so that no single
    noisy sample carries the whole fit.
    """
    scale = float(np.max(envelope))
    relative = envelope / scale
    powers = np.stack([relative**i for i in range(order + 1)])
    columns = np.concatenate([np.ones((1, len(envelope))), -cumulative(powers, step)]).T
    found = weighted_inverse(columns.T, weight) @ relative
    found *= scale
    found[1:] /= scale ** np.arange(order + 1)
    return found


def fit_envelope(envelope: Array, step: float, start: Array, weight: Array, rounds: int = 3) -> EnvelopeFit:
    """Fit the integrated envelope of eq. (5) to `envelope` (m,), Gauss-Newton from `start` (k(0), c_0..c_n).

    The sensitivities are exact: a change of the envelope decays as E = exp(-int sum i c_i k^(i-1)).
    """
    parameters = start.copy()
    order = len(start) - 2
    exponents = np.arange(order + 1.0)
    for _ in range(rounds):
        fit, jacobian = _sensitivities(parameters, step, len(envelope), exponents)
        gain = weighted_inverse(jacobian, weight)
        change = gain @ (envelope - fit)
        parameters = parameters + change
        parameters[0] = max(parameters[0], 0.1 * start[0])
    fit = integrate_envelope(parameters[0], parameters[1:], step, len(envelope))
    variance = float(np.var(envelope)) + 1e-300
    return EnvelopeFit(parameters, fit, gain, float(100 * np.mean((envelope - fit) ** 2) / variance))


def _sensitivities(parameters: Array, step: float, count: int, exponents: Array) -> tuple[Array, Array]:
    fit = integrate_envelope(parameters[0], parameters[1:], step, count)
    powers = fit[None, :] ** exponents[:, None]
    slope = np.sum((exponents * parameters[1:])[1:, None] * powers[:-1], axis=0)
    decay = np.exp(np.clip(-cumulative(slope, step), -50, 50))
    jacobian = np.concatenate([np.ones((1, count)), -cumulative(powers / decay, step)]) * decay
    return fit, jacobian


def fit_phase(phase: Array, envelope: Array, step: float, orders: tuple[int, ...], weight: Array) -> PhaseFit:
    """Fit phi(0) + sum d_i int k^(i-1) dt over the odd `orders` to `phase` (m,), weighted by the envelope.

    The backbone w = d_1 + d_3 k^2 + d_5 k^4 integrated in time, as eq. (10) integrates the envelope.
    The phase's noise is the sample's over the envelope, hence the weight. `parameters` is phi(0), d_1, d_3 ....
    """
    scale = float(np.max(envelope))
    powers = np.stack([(envelope / scale) ** (i - 1) for i in orders])
    columns = np.concatenate([np.ones((1, len(phase))), cumulative(powers, step)]).T
    units = np.concatenate([[1.0], scale ** (np.array(orders) - 1.0)])
    gain = weighted_inverse(columns.T, envelope * weight) / units[:, None]
    parameters = gain @ (phase - phase[0])
    parameters[0] += phase[0]
    return PhaseFit(parameters, phase_model(parameters, envelope, step, orders), gain)


def phase_model(parameters: Array, envelope: Array, step: float, orders: tuple[int, ...]) -> Array:
    """Return phi(0) + sum d_i int k^(i-1) dt at the points of `envelope` (m,)."""
    slopes = np.zeros(len(envelope))
    for order, slope in zip(orders, parameters[1:], strict=True):
        slopes += slope * envelope ** (order - 1)
    return np.asarray(parameters[0] + cumulative(slopes, step))
