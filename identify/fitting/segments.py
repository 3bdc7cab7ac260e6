"""Episodes: a long record is fitted in pieces, each with a start of its own.

Over hundreds of cycles a clock, a temperature or a draught moves the phase by more than any force does, and a free
run from one start would take it for a force. Pieces of a dozen cycles, spread over the decay, share the
physics and forgive the wandering between them.
"""

from dataclasses import replace

import numpy as np

from identify.preprocessing.prepared_decay import Setting

_LONG_CYCLES = 60.0
_EPISODE_CYCLES = 12.0
_MOST = 6


def episodes(setting: Setting) -> tuple[Setting, ...]:
    """Return a long release as up to six episodes spread evenly over it; a short one as it is.

    A driven motion is kept in step by its force, and stays whole.
    """
    span, n = setting.span, len(setting.span)
    cycle = 2.0 * np.pi / setting.frequency * span.rate
    if span.force is not None or n / cycle < _LONG_CYCLES:
        return (setting,)
    length = int(_EPISODE_CYCLES * cycle)
    starts = np.linspace(0, n - length, _MOST).astype(int)
    return tuple(_episode(setting, int(first), length) for first in starts)


def _episode(setting: Setting, first: int, length: int) -> Setting:
    part = slice(first, first + length)
    motion, span = setting.motion, setting.span
    return replace(
        setting,
        span=span.with_(
            time=span.time + first / span.rate,
            readings={c: r[part] for c, r in span.readings.items()},
            used={c: _with_lead(m[part], span.lead) for c, m in span.used.items()},
            prelude=span.prelude if first == 0 else None,
            episode=True,
        ),
        motion=replace(
            motion,
            displacement=motion.displacement[part],
            velocity=motion.velocity[part],
            acceleration=motion.acceleration[part],
            valid=motion.valid[part],
        ),
        lost={c: m[part] for c, m in setting.lost.items()},
        rest=setting.rest if first == 0 else None,
    )


def _with_lead(used: np.ndarray, lead: int) -> np.ndarray:
    mask = np.array(used)
    mask[:lead] = False
    return mask
