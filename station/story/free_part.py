"""The part of a record in which the mass swings freely, after a push or a drive that stops."""

import numpy as np

from identify.arrays import Array
from identify.free_decay import FreeDecay
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency
from identify.signal.running import running_maximum, running_minimum

GROWN = 0.6
"""A motion that was once below this share of its largest amplitude, earlier, has been pushed or driven."""

STEADY = 3.0
"""A plateau that lasts this many times as long as the decay takes to fall by as much again was driven."""

DECAYED = 0.6
LEFT = 0.1
"""A motion that ends above the first share of its largest amplitude, or holds a level above the second one over the
last third of its record, is still being driven, or too short to tell. The level is the largest amplitude in each half of
that third: what is driven may beat to its end.
"""

HELD = 0.95
"""So much of its level a motion that is driven holds from one half of the last third to the other."""

FEWEST_PERIODS = 4.0


def goes_on(decay: FreeDecay) -> bool:
    """Check whether the motion of a record, or of a piece, is seen not to fall; half the span of a period is its amplitude.

    Of fewer than four periods that is not known, and so not said.
    """
    found = _amplitudes(decay)
    return found is not None and _goes_on(found[0], float(found[0].max()))


def free_from(decay: FreeDecay) -> tuple[int, str] | None:
    """Return the sample from which the mass swings freely and what came before it, or None where the motion decays from
    the beginning, or does not decay.

    The amplitude is half the span of one period. A motion that grows was pushed; one whose amplitude stays within 10 %
    for three times as long as it then takes to lose the next 10 % was driven, which no damping law does.
    """
    found = _amplitudes(decay)
    if found is None:
        return None
    amplitude, period = found
    largest = float(amplitude.max())
    if _goes_on(amplitude[period // 2 : -(period // 2) or None], largest):
        return None
    high = np.flatnonzero(amplitude >= 0.9 * largest)
    fallen = np.flatnonzero(amplitude[high[-1] :] < 0.8 * largest)
    if not len(fallen):
        return None
    steady = int(high[-1] - high[0]) > STEADY * max(int(fallen[0]), period)
    if steady:
        top = int(np.flatnonzero(amplitude >= 0.95 * largest)[-1])
        return min(top + period // 2, len(amplitude) - 1), "a drive that stops"
    top = int(np.argmax(amplitude))
    if top > period and float(amplitude[:top].min()) < GROWN * largest:
        return min(top + period // 2, len(amplitude) - 1), "a push"
    return None


def _amplitudes(decay: FreeDecay) -> tuple[Array, int] | None:
    """Return the amplitude (n,) and the period in samples; None where fewer than four periods are seen."""
    values, known = next(iter(decay.channels.values())), decay.known
    filled = bridge(values, known)
    frequency = dominant_frequency(filled, decay.rate, 0 if decay.displacement is not None else 1)
    if frequency <= 0.0 or len(filled) * frequency / decay.rate < FEWEST_PERIODS:
        return None
    period = max(2, round(decay.rate / frequency))
    span: Array = running_maximum(filled, period) - running_minimum(filled, period)
    return 0.5 * span, period


def _goes_on(amplitude: Array, largest: float) -> bool:
    """Check whether the motion does not die away."""
    before, end = (float(half.max()) for half in np.array_split(amplitude, 6)[-2:])
    return float(amplitude[-1]) > DECAYED * largest or (end > LEFT * largest and end > HELD * before)
