"""The window of a channel that its ridge is fitted on: free, above its noise, not yet near sticking."""

import numpy as np

from identify.errors import NotIdentifiable
from identify.free_decay import CHANNELS, FreeDecay
from identify.preprocessing.decimation import flat_frequency
from identify.preprocessing.noise import noise_levels
from identify.preprocessing.usable import (
    first_free_sample,
    last_large_sample,
    require_cycles,
)
from identify.signal.averaging import integrate_envelope
from identify.signal.fractional_delay import bridge
from identify.wavelet.ridge_fit import Observed, envelope_and_phase, first_fit, observe

_FEWEST_CYCLES = 3.0
_STOP_AT_FIRST = 0.1  # of the largest amplitude, until dry friction is known
_STOP_AT_DRY_ZONE = 2.5  # fit down to this many times mu_0 / w0^2, where sticking is one cycle away
_STOP_AT_NOISE = 6.0  # and to this many standard deviations of a sample


def observe_window(decay: FreeDecay) -> tuple[int, Observed]:
    """Return the first sample of the window and the ridge of its channel, from a rough ridge of the whole record.

    Raises NotIdentifiable when the record is driven, holds no oscillation, or too little of it.
    """
    channel, samples = next(iter(decay.channels.items()))
    derivatives, valid = CHANNELS.index(channel), decay.known
    if not np.any(valid):
        raise NotIdentifiable(f"not a single sample of the {channel} is valid")
    whole = bridge(samples, valid)
    start = first_free_sample(decay)
    frequency = flat_frequency(whole[start:], decay.rate)
    if frequency <= 0:
        raise NotIdentifiable(f"no oscillation stands out of the {channel} after the release")
    start = first_free_sample(decay, frequency)
    if decay.driven:
        raise NotIdentifiable(
            "a force drives the motion to the end of the record; the wavelet method needs a free decay"
        )
    require_cycles(len(whole) - start, decay.rate, frequency, _FEWEST_CYCLES)
    noise = noise_levels(decay)[channel]
    rough = observe(whole[start:], valid[start:], decay.rate, derivatives, 2 * np.pi * frequency, noise)
    envelope, _, angular = envelope_and_phase(rough, rough.samples)
    quiet = _STOP_AT_NOISE * noise / rough.angular_frequency**derivatives
    few = min(int(_FEWEST_CYCLES * decay.rate / frequency) + 1, len(whole) - start)
    large = last_large_sample(envelope, max(quiet, _STOP_AT_FIRST * float(np.max(envelope))))
    still = NotIdentifiable(f"the {channel} moves no more than its noise; release from a larger amplitude")
    if large < 1:
        raise still
    stop = max(min(large * int(rough.points[1]), len(whole) - start), few)
    angular_frequency = float(np.median(angular[:large]))
    for last in (False, False, True):
        part = slice(start, start + stop)
        observed = observe(whole[part], valid[part], decay.rate, derivatives, angular_frequency, noise)
        if last:
            break
        parameters = first_fit(observed, 1, (1,)).envelope_fit.parameters
        dry = parameters[1] * np.pi / 2 / angular_frequency
        # the rough envelope is smeared where the mass sticks: read the end off the fitted one
        fitted = integrate_envelope(parameters[0], parameters[1:], 1 / decay.rate, len(whole) - start)
        better = max(last_large_sample(fitted, max(quiet, _STOP_AT_DRY_ZONE * dry)), few)
        if abs(better - stop) < 0.02 * stop:
            break
        stop = better
    if float(np.median(envelope[:large])) < quiet:
        raise still
    return start, observed
