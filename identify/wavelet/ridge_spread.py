"""The covariance of the ridge's values: the channel's noise carried through the transform, and the misfit.

Averaging gives the gains by which envelope and phase are turned into parameters. How the exact decay, seen through the
transform, answers to each parameter is measured by computing it once more for each; its product with the gains is the
identity where averaging is right, and under strong damping is what their errors lack.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.signal.averaging import integrate_envelope
from identify.signal.covariance import misfit_covariance
from identify.signal.harmonic_windows import Complex
from identify.wavelet.envelope import EnvelopeFit, PhaseFit, phase_model
from identify.wavelet.ridge_fit import Observed, RidgeFit, seen_of


def spreads_of(observed: Observed, fit: RidgeFit) -> tuple[Array, Array]:
    """Return the standard errors of k(0), c_0, ... and of phi(0), w_1, ... of `fit`.

    White noise of the samples carried through the transform, the misfit where there is one, and how far the fit is from
    settled, by Newton's step or by one plain round, whichever is more. Raises RunsAway where a motion so near the fitted
    one grows without end.
    """
    gain, phase_gain = fit.envelope_fit.gain, fit.phase_fit.gain
    cut = len(gain)
    on_points = np.concatenate([gain + 0j, 1j * phase_gain / _amplitude(fit)]) * _turn(observed)
    covariance = _carried(observed, on_points)
    spread = np.sqrt(observed.variance)
    covariance[:cut, :cut] += _misfit(observed, fit.envelope - fit.envelope_fit.fit, spread, gain, cut)
    covariance[cut:, cut:] += _misfit(
        observed, fit.phase - fit.phase_fit.fit, spread / _amplitude(fit), phase_gain, len(phase_gain)
    )
    mixing = mixing_of(observed, fit)
    covariance = mixing @ covariance @ mixing.T
    errors = np.sqrt(np.diag(covariance))
    if fit.ahead is not None:
        errors = np.hypot(errors, np.maximum(np.abs(mixing @ fit.ahead), np.abs(fit.ahead)))
    return errors[:cut], errors[cut:]


def mixing_of(observed: Observed, fit: RidgeFit) -> Array:
    """Return what carries parameters gained by averaging into those of the exact decay, shape (p, p)."""
    seen = seen_of(observed, fit)
    size = _sizes(fit, observed)
    answer = np.empty((len(size), len(size)))
    for i, step in enumerate(1e-3 * size):
        beside = moved(observed, fit, np.where(np.arange(len(size)) == i, step, 0.0))
        envelope, phase = (there - here for there, here in zip(seen_of(observed, beside), seen, strict=True))
        answer[:, i] = np.concatenate([fit.envelope_fit.gain @ envelope, fit.phase_fit.gain @ phase]) / step
    scale = size[:, None] / size
    return np.asarray(np.linalg.pinv(answer / scale, rcond=1e-6) * scale)


def clearances_of(
    observed: Observed, fit: RidgeFit, trials: Sequence[EnvelopeFit | PhaseFit], *, phase: bool
) -> list[float]:
    """Count the standard errors between zero and each trial's highest damping, or stiffness where of the `phase`."""
    gains = np.stack([trial.gain[-1] for trial in trials])
    measured, spread = fit.envelope, np.sqrt(observed.variance)
    on_points = gains * _turn(observed)
    if phase:
        measured, spread = fit.phase, spread / _amplitude(fit)
        on_points = 1j * on_points / _amplitude(fit)
    variances = np.diag(_carried(observed, on_points)).copy()
    for at, trial in enumerate(trials):
        left = measured - trial.fit
        variances[at] += _misfit(observed, left, spread, gains[at : at + 1], len(trial.gain))[0, 0]
    highest = np.abs([trial.parameters[-1] for trial in trials])
    return [float(x) for x in highest / np.sqrt(variances + 1e-300)]


def _misfit(observed: Observed, left: Array, spread: Array, gain: Array, parameters: int) -> Array:
    used = observed.weight > 0
    return misfit_covariance(
        left[used] / spread[used], gain[:, used] * spread[used], observed.independent, parameters
    )


def _amplitude(fit: RidgeFit) -> Array:
    return np.asarray(np.maximum(np.abs(fit.envelope), 1e-3 * np.max(np.abs(fit.envelope))))


def _turn(observed: Observed) -> Complex:
    scale, (_, phase, _) = observed.angular_frequency**observed.derivatives, observed.measured
    return np.asarray(np.exp(1j * (phase + observed.derivatives * np.pi / 2)) / scale)


def _carried(observed: Observed, on_points: Complex) -> Array:
    rows = observed.ridge.weights_on_samples(on_points, len(observed.samples))
    return observed.noise**2 * rows @ rows.T


def _sizes(fit: RidgeFit, observed: Observed) -> Array:
    """How far each parameter may go before the decay looks different: k(0), c_0, ..., phi(0), w_1, ...."""
    start = fit.envelope_fit.parameters[0]
    duration = len(observed.samples) / observed.rate
    rate = start / duration
    damping = [rate / start**i for i in range(fit.order + 1)]
    stiffness = [1 / duration / start ** (order - 1) for order in fit.stiffness_orders]
    return np.array([start, *damping, 1.0, *stiffness])


def moved(observed: Observed, fit: RidgeFit, change: Array) -> RidgeFit:
    """Change the parameters of a fit, (p,), and what the averaged model gives for them; not what was measured."""
    cut = fit.order + 2
    decay, phases = fit.envelope_fit.parameters + change[:cut], fit.phase_fit.parameters + change[cut:]
    points, step = len(fit.envelope), observed.step
    model = integrate_envelope(decay[0], decay[1:], step, points)
    turned = phase_model(phases, model, step, fit.stiffness_orders)
    return replace(
        fit,
        envelope_fit=replace(fit.envelope_fit, parameters=decay, fit=model),
        phase_fit=replace(fit.phase_fit, parameters=phases, fit=turned),
    )
