"""A sensor or physics: do the two channels describe one motion, whatever forces act on it?"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask, frozen
from identify.comparison.multiple_shooting import delayed
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.smoothing import gain_of, slope, smooth, without_line

_BAND = 5.0
_NEAR_REVERSAL = 4


@dataclass(frozen=True, eq=False)
class KinematicCheck:
    """The disagreement of the channels, a less D^2 u.

    `chi_square` is its reduced chi-square, 1 when noise explains it, and `chi_square_std` the standard error of that.
    `residual` (n,) in m/s^2 is the disagreement below five times the frequency, `noise` what noise alone leaves of it (rms).
    """

    chi_square: float
    chi_square_std: float
    residual: Array
    noise: float

    @property
    def significance(self) -> float:
        """By how many standard errors the disagreement exceeds the noise."""
        return (self.chi_square - 1.0) / self.chi_square_std

    @property
    def rms(self) -> float:
        """Size of the residual, m/s^2."""
        return float(np.sqrt(np.mean(self.residual**2)))


def check_kinematics(
    prepared: PreparedDecay, window: FitWindow, frequency: float, floor_error: float
) -> KinematicCheck | None:
    """Compare both channels with the one motion that suits them best; None with a single channel.

    `floor_error` is the relative standard error of the noise floor.
    """
    aligned, motion = prepared.alignment, prepared.motion
    if aligned is None or not window.paired:
        return None
    low = "displacement" if "displacement" in window.readings else "velocity"
    noise_high = window.sigma["acceleration"] / abs(aligned.gain.value)
    high = window.readings["acceleration"] / aligned.gain.value - motion.acceleration
    read = delayed(motion.displacement, motion.velocity, motion.acceleration, aligned.lag.value, window.rate)
    left = window.readings[low] - read[0 if low == "displacement" else 1]
    inside = motion.valid & window.used["acceleration"] & window.used[low] & ~_near_reversals(motion.velocity)
    high, left = without_line(high, inside), without_line(left, inside)
    total = float(np.sum((high[inside] / noise_high) ** 2) + np.sum((left[inside] / window.sigma[low]) ** 2))
    degrees = max(int(inside.sum()) - 6, 1)
    corner = _BAND * frequency / (2.0 * np.pi * window.rate)
    disagreement = smooth(np.where(inside, high, 0.0), corner) - _derivative(
        smooth(np.where(inside, left, 0.0), corner), window.rate, 2 if low == "displacement" else 1
    )
    return KinematicCheck(
        total / degrees,
        float(np.hypot(np.sqrt(2.0 / degrees), 2.0 * floor_error)),
        frozen(disagreement),
        _expected(noise_high, window.sigma[low], corner, window.rate, 2 if low == "displacement" else 1),
    )


def _near_reversals(velocity: Array) -> Mask:
    """Where dry friction turns around between two samples, and a smooth motion cannot follow, shape (n,)."""
    turns = np.zeros(len(velocity), dtype=bool)
    turns[:-1] = np.signbit(velocity[1:]) != np.signbit(velocity[:-1])
    return np.convolve(turns, np.ones(2 * _NEAR_REVERSAL + 1), "same") > 0.5


def _derivative(values: Array, rate: float, order: int) -> Array:
    for _ in range(order):
        values = slope(values, rate)
    return values


def _expected(noise_high: float, noise_low: float, corner: float, rate: float, order: int) -> float:
    """Rms that white noise of both channels leaves below the corner."""
    fraction = (np.arange(1024) + 0.5) / 2048
    passed = gain_of(corner, fraction)
    omega = 2.0 * np.pi * fraction * rate
    return float(np.sqrt(np.mean(passed**2 * (noise_high**2 + omega ** (2 * order) * noise_low**2))))
