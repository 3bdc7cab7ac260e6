"""A sensor or physics: do the two channels describe one motion, whatever forces act on it?"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.comparison.multiple_shooting import delayed
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.smoothing import without_line

_NEAR_REVERSAL = 4


@dataclass(frozen=True)
class KinematicCheck:
    """The disagreement of the channels, each in standard errors of the noise.

    `significance` is by how much the misfit of both to one motion exceeds it, a steady drift of their zeros left out;
    `drift` is the size of that drift of the acceleration's zero, which no force can cause.
    """

    significance: float
    drift: float


def check_kinematics(prepared: PreparedDecay, window: FitWindow, floor_error: float) -> KinematicCheck | None:
    """Compare both channels with the one motion that suits them best; None with a single channel.

    `floor_error` is the relative standard error of the noise floor.
    """
    aligned, motion = prepared.alignment, prepared.motion
    if aligned is None or not window.paired:
        return None
    low = "displacement" if "displacement" in window.readings else "velocity"
    noise = window.sigma["acceleration"] / abs(aligned.gain.value)
    read = delayed(motion.displacement, motion.velocity, motion.acceleration, aligned.lag.value, window.rate)
    left = window.readings[low] - read[0 if low == "displacement" else 1]
    inside = motion.valid & window.used["acceleration"] & window.used[low] & ~_near_reversals(motion.velocity)
    if not inside.any():  # of few readings a cycle all are near a reversal, and contradict nothing
        return KinematicCheck(0.0, 0.0)
    uneven = window.readings["acceleration"] / aligned.gain.value - motion.acceleration
    high, left = without_line(uneven, inside), without_line(left, inside)
    total = float(np.sum((high[inside] / noise) ** 2) + np.sum((left[inside] / window.sigma[low]) ** 2))
    degrees = max(int(inside.sum()) - 6, 1)
    line = (uneven - high)[inside]
    return KinematicCheck(
        (total / degrees - 1.0) / float(np.hypot(np.sqrt(2.0 / degrees), 2.0 * floor_error)),
        float(np.linalg.norm(line - line.mean())) / noise,
    )


def _near_reversals(velocity: Array) -> Mask:
    """Where dry friction turns around between two samples, and a smooth motion cannot follow, shape (n,)."""
    turns = np.zeros(len(velocity), dtype=bool)
    turns[:-1] = np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
    return np.convolve(turns, np.ones(2 * _NEAR_REVERSAL + 1), "same") > 0.5
