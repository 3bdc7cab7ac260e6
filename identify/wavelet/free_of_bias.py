"""A ridge freed of the transform's own bias, in rounds that take off what the fitted model shows of it.

Where averaging is right a round leaves a small share of the error. Where it is not, under strong damping or beside a strong
cubic spring, it leaves most of it, or more than there was: Newton's method follows, by the measured answer of the exact
decay to each parameter.
"""

from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.wavelet.envelope import fit_envelope, fit_phase, phase_model
from identify.wavelet.ridge_fit import Observed, RidgeFit, RunsAway, seen_of
from identify.wavelet.ridge_spread import mixing_of, moved

_SETTLED = 0.05
_ROUNDS = 30
_PLAIN = 6
"""Rounds before Newton's method: a nearly linear decay needs fewer."""


def free_of_bias(observed: Observed, fit: RidgeFit) -> RidgeFit:
    """Take the transform's own bias off, as the model `fit` shows it, and fit again, until nothing changes.

    "Nothing" is a twentieth of the envelope's noise. Where 30 rounds do not settle, or lead to a motion that runs away, the
    fit before the round of least change counts; RunsAway where the first does.
    """
    fit = sound = replace(fit, ahead=None)
    least = np.inf
    for at in range(_ROUNDS):
        try:
            following, change = _following(observed, fit)
            ahead = _parameters(following) - _parameters(fit)
            if at >= _PLAIN:
                step = mixing_of(observed, fit) @ ahead if change < least else 0.5 * ahead
                following = moved(observed, following, step - ahead)
        except RunsAway:
            if not at:
                raise
            return sound
        if change < _SETTLED:
            return following
        if change < least:
            sound, least = replace(fit, ahead=ahead), change
        fit = following
    return sound


def _following(observed: Observed, fit: RidgeFit) -> tuple[RidgeFit, float]:
    """Return the fit after one round, and how far that moves the ridge, in standard deviations of the envelope's noise."""
    raw_envelope, raw_phase, _ = observed.measured
    seen_envelope, seen_phase = seen_of(observed, fit)
    model = fit.envelope_fit.fit
    averaged = phase_model(fit.phase_fit.parameters, model, observed.step, fit.stiffness_orders)
    envelope = raw_envelope - (seen_envelope - model)
    phase = raw_phase - (seen_phase - averaged)
    size = np.abs(envelope)
    change = np.maximum(np.abs(envelope - fit.envelope), np.abs(phase - fit.phase) * size)
    change *= observed.weight > 0
    start = fit.envelope_fit.parameters
    following = replace(
        fit,
        envelope_fit=fit_envelope(envelope, observed.step, start, observed.weight, rounds=1),
        phase_fit=fit_phase(phase, size, observed.step, fit.stiffness_orders, observed.weight),
        envelope=envelope,
        phase=phase,
    )
    return following, float(np.max(change / np.sqrt(observed.variance)))


def _parameters(fit: RidgeFit) -> Array:
    return np.concatenate([fit.envelope_fit.parameters, fit.phase_fit.parameters])
