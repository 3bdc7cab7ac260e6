"""The motion while a release happens: from the mass at rest to the first sample of a fit, for forces with memory.

Where a hand, a magnet or a hammer changes the acceleration within a sample or two, no smooth motion passes through the
readings. The acceleration, integrated from rest, does not ask for one.
"""

import numpy as np

from identify.arrays import Array
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import AlignedDecay
from identify.preprocessing.fit_window import PreReleaseMotion
from identify.preprocessing.motion import reconstruct
from identify.preprocessing.release import Release
from identify.signal.fractional_delay import bridge

_PRELUDE_SAMPLES = 4
_PRELUDE_MARGIN = 16


def pre_release_motion(aligned: AlignedDecay, release: Release, zero: float) -> PreReleaseMotion | None:
    """Return the motion from just before the release to the start of the span; None when the rest was not seen.

    `zero` is the spring's (m). With both channels the acceleration is integrated from rest, and what that is off
    the smooth motion at the end, where it is free, is taken out in proportion to the time since the release: velocity first,
    then displacement.
    """
    decay = aligned.decay
    first = release.index - _PRELUDE_SAMPLES
    held = release.rest[1] - release.rest[0]
    if decay.displacement is None or held < _PRELUDE_SAMPLES or first < release.rest[0]:
        return None
    motion = reconstruct(decay.with_(release=max(first - _PRELUDE_MARGIN, 0)))
    part = slice(first - motion.start, release.settle - motion.start + 1)
    time = decay.time[first : release.settle + 1] - release.time_s
    u, v = motion.displacement[part], motion.velocity[part]
    if decay.acceleration is not None:
        u, v = _integrated(decay, release, time, (u, v))
    return PreReleaseMotion(time, u - zero, v)


def _integrated(
    decay: FreeDecay, release: Release, time: Array, smooth: tuple[Array, Array]
) -> tuple[Array, Array]:
    assert decay.acceleration is not None
    assert decay.displacement is not None
    still = slice(*release.rest)
    first = release.settle + 1 - len(time)
    whole = bridge(decay.acceleration, np.isfinite(decay.acceleration))
    a = whole[first : release.settle + 1] - float(np.nanmedian(decay.acceleration[still]))
    held = float(np.nanmedian(decay.displacement[still]))
    step = 1.0 / decay.rate
    v = np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]) * step)])
    u = held + np.concatenate([[0.0], np.cumsum(v[:-1] * step + (2.0 * a[:-1] + a[1:]) * step**2 / 6.0)])
    since = np.maximum(time, 0.0)
    share = since / since[-1] if since[-1] > 0.0 else np.ones(len(time))
    wrong = float(smooth[1][-1] - v[-1])
    v = v + wrong * share
    u = u + wrong * 0.5 * since * share
    return np.asarray(u + float(smooth[0][-1] - u[-1]) * share), np.asarray(v)
