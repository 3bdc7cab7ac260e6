"""The ridge fit under strong damping: Newton's method where taking off the bias settles too slowly.

Averaging gives the gains by which envelope and phase are turned into parameters. How the exact decay, seen
through the transform, answers to each parameter is measured by computing it once more for each; its product
with the gains is the identity where averaging is right, and what the plain rounds lack where it is not.
"""

from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.signal.averaging import integrate_envelope
from identify.wavelet.ridge_fit import Observed, RidgeFit, free_of_bias, phase_model, seen_of

_ROUNDS = 8
_SETTLED = 1e-4  # of a parameter's own size


def settle(observed: Observed, fit: RidgeFit) -> RidgeFit:
    """Return `fit` freed of bias: in plain rounds, and by Newton's method where these do not settle.

    Raises RunsAway where the orders of `fit` describe no motion that decays.
    """
    plain = free_of_bias(observed, fit)
    return plain if plain.settled else _newton(observed, plain)


def _newton(observed: Observed, fit: RidgeFit) -> RidgeFit:
    envelope, phase = fit.envelope + fit.bias_envelope, fit.phase + fit.bias_phase
    size = _sizes(fit, observed)
    for _ in range(_ROUNDS):
        seen = seen_of(observed, fit)
        gap = _gained(fit, envelope - seen[0], phase - seen[1])
        answer = np.empty((len(size), len(size)))
        for i in range(len(size)):
            moved = seen_of(observed, _moved(fit, np.where(np.arange(len(size)) == i, 1e-3 * size, 0.0)))
            answer[:, i] = _gained(fit, moved[0] - seen[0], moved[1] - seen[1]) / (1e-3 * size[i])
        scale = size[:, None] / size
        mixing = np.linalg.pinv(answer / scale, rcond=1e-6) * scale
        change = mixing @ gap
        largest = float(np.max(np.abs(change) / size))
        fit = _moved(fit, change * min(1.0, 0.3 / max(largest, 1e-300)))
        if largest < _SETTLED:
            break
    seen = seen_of(observed, fit)
    bias = seen[0] - fit.envelope_fit.fit, seen[1] - fit.phase_fit.fit
    left = envelope - bias[0] - fit.envelope_fit.fit
    misfit = float(100 * np.mean(left**2) / np.var(envelope))
    return replace(
        fit,
        envelope_fit=replace(fit.envelope_fit, mse_percent=misfit),
        envelope=envelope - bias[0],
        phase=phase - bias[1],
        bias_envelope=bias[0],
        bias_phase=bias[1],
        mixing=mixing,
    )


def _sizes(fit: RidgeFit, observed: Observed) -> Array:
    """How far each parameter may go before the decay looks different: k(0), c_0, ..., phi(0), w_1, ...."""
    start = fit.envelope_fit.parameters[0]
    duration = len(observed.samples) / observed.rate
    rate = start / duration
    damping = [rate / start**i for i in range(fit.order + 1)]
    stiffness = [1 / duration / start ** (order - 1) for order in fit.stiffness_orders]
    return np.array([start, *damping, 1.0, *stiffness])


def _moved(fit: RidgeFit, change: Array) -> RidgeFit:
    cut = fit.order + 2
    decay, phases = fit.envelope_fit.parameters + change[:cut], fit.phase_fit.parameters + change[cut:]
    points, step = len(fit.envelope), fit.step
    model = integrate_envelope(decay[0], decay[1:], step, points)
    turned = phase_model(phases, model, step, fit.stiffness_orders)
    return replace(
        fit,
        envelope_fit=replace(fit.envelope_fit, parameters=decay, fit=model),
        phase_fit=replace(fit.phase_fit, parameters=phases, fit=turned),
    )


def _gained(fit: RidgeFit, envelope: Array, phase: Array) -> Array:
    return np.concatenate([fit.envelope_fit.gain @ envelope, fit.phase_fit.gain @ phase])
