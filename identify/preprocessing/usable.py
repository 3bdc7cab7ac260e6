"""The usable stretch of a record: after the hand has let go, before the mass comes near to sticking."""

import numpy as np

from identify.arrays import Array
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay

HAND_S = 0.030
"""A hand has surely let go this long after the release: it takes 20 ms at most, and channels differ by 3 ms."""


def first_free_sample(decay: FreeDecay, frequency: float | None = None) -> int:
    """Return the first sample at which the hand has surely let go.

    `frequency` (Hz) shortens the wait where 30 ms is more than a quarter of a cycle. A record without a rest
    before the release began in mid-decay: no hand, no wait.
    """
    if decay.rest[1] <= decay.rest[0]:
        return decay.start
    wait = HAND_S if frequency is None else min(HAND_S, 0.25 / frequency)
    return decay.start + int(np.ceil(wait * decay.rate))


def last_large_sample(envelope: Array, threshold: float) -> int:
    """Return one past the last sample before `envelope` (n,) first stays below `threshold`."""
    below = np.flatnonzero(envelope < threshold)
    return int(below[0]) if len(below) else len(envelope)


def require_cycles(samples: int, rate: float, frequency: float, fewest: float) -> None:
    """Raise NotIdentifiable when `samples` at `rate` hold fewer than `fewest` cycles or too few samples a cycle."""
    cycles = samples * frequency / rate
    if cycles < fewest:
        raise NotIdentifiable(
            f"only {cycles:.1f} cycles of free motion above friction and noise, {fewest:g} are needed; "
            "release from a larger amplitude or record longer"
        )
    if rate < 3 * frequency:
        raise NotIdentifiable(
            f"{rate / frequency:.1f} samples a cycle are too few to follow {frequency:.3g} Hz; "
            f"record at {4 * frequency:.3g} Hz or faster"
        )
