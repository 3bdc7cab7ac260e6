"""The spread of what the ridge says: the channel's noise carried through the transform, and the misfit."""

import numpy as np

from identify.arrays import Array
from identify.envelope import EnvelopeFit, PhaseFit
from identify.morlet import weights_on_samples
from identify.ridge_fit import Observed, RidgeFit
from identify.spread import misfit_covariance


def envelope_covariance(
    observed: Observed, fit: RidgeFit, trial: EnvelopeFit, *, last: bool = False
) -> Array:
    """Return the covariance of k(0), c_0, ... of a `trial` on the envelope of `fit`, (n + 2, n + 2).

    White noise of the samples, and the misfit where there is one. Of the `last` coefficient alone, (1, 1), where
    no more is asked.
    """
    gain = trial.gain[-1:] if last else trial.gain
    misfit = _misfit(observed, fit.envelope - trial.fit, np.sqrt(observed.variance), gain, len(trial.gain))
    return _noise_in_envelope(observed, fit, gain) + misfit


def phase_covariance(observed: Observed, fit: RidgeFit, trial: PhaseFit, *, last: bool = False) -> Array:
    """Return the covariance of phi(0), w_1, ... of a `trial` on the phase of `fit`; as `envelope_covariance`."""
    gain = trial.gain[-1:] if last else trial.gain
    amplitude = np.maximum(np.abs(fit.envelope), 1e-3 * np.max(np.abs(fit.envelope)))
    spread = np.sqrt(observed.variance) / amplitude
    misfit = _misfit(observed, fit.phase - trial.fit, spread, gain, len(trial.gain))
    return _noise_in_phase(observed, fit, gain) + misfit


def _misfit(observed: Observed, left: Array, spread: Array, gain: Array, parameters: int) -> Array:
    used = observed.weight > 0
    return misfit_covariance(
        left[used] / spread[used], gain[:, used] * spread[used], observed.independent, parameters
    )


def _noise_in_envelope(observed: Observed, fit: RidgeFit, gain: Array) -> Array:
    return _carried(observed, gain * _turn(observed, fit))


def _noise_in_phase(observed: Observed, fit: RidgeFit, gain: Array) -> Array:
    amplitude = np.abs(fit.envelope)
    amplitude = np.maximum(amplitude, 1e-3 * np.max(amplitude))
    return _carried(observed, 1j * gain * _turn(observed, fit) / amplitude)


def _turn(observed: Observed, fit: RidgeFit) -> Array:
    scale = observed.angular_frequency**observed.derivatives
    return np.exp(1j * (fit.phase + fit.bias_phase + observed.derivatives * np.pi / 2)) / scale


def _carried(observed: Observed, on_points: Array) -> Array:
    rows = weights_on_samples(observed.ridge, on_points)
    return observed.noise**2 * rows @ rows.T
