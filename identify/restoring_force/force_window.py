"""The window that the restoring force is fitted on: the motion, where it is free and large, and its noise."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.motion import Motion
from identify.preprocessing.noise import noise_levels
from identify.preprocessing.sampling import too_coarse
from identify.preprocessing.usable import usable

_FEWEST_CYCLES = 3.5  # windows of two cycles, and room to slide them
_REACH = 2  # samples from a reversal over which the friction's jump is smeared
_BLUR_CYCLES = 0.03  # by which the smoothing of a lone displacement rounds a kink
_LATE = 1e-5  # of a cycle, by which all reversals may be misplaced alike
_LATE_ALONE = 4e-5  # where smoothing has rounded them
_SURE_SIGN = 3.0  # standard errors of the velocity below which its sign is noise


@dataclass(frozen=True, eq=False)
class ForceWindow:
    """The part of the motion that identifies, with its noise and the recorded force.

    `noise` gives the variance of a sample of the displacement by angular frequency (rad/s).
    """

    motion: Motion
    first: int
    stop: int
    valid: Mask
    angular_frequency: float
    force: Array | None
    noise: Callable[[Array], Array]

    @property
    def blur(self) -> int:
        """Samples to either side of a reversal over which smoothing has rounded the velocity."""
        if self.motion.source != "displacement":
            return 0
        return int(_BLUR_CYCLES * 2 * np.pi * self.motion.rate / self.angular_frequency)

    @property
    def late(self) -> float:
        """Time (s) by which all reversals may be placed too late alike: the least of it stays after all care."""
        share = _LATE_ALONE if self.blur else _LATE
        return share * 2 * np.pi / self.angular_frequency

    @property
    def middle(self) -> float:
        """The mean displacement under a smooth window, to which both ends add nothing."""
        u = self.cut(self.motion.displacement)
        return float(np.average(u, weights=np.sin(np.pi * (np.arange(len(u)) + 0.5) / len(u)) ** 4))

    def about(self, zero: float) -> Self:
        """Return the window with displacements counted from one of them."""
        return replace(self, motion=replace(self.motion, displacement=self.motion.displacement - zero))

    def cut(self, values: Array) -> Array:
        """Return the window's part of `values`, which are as long as the motion."""
        return values[self.first : self.stop]


def noise_spectrum(decay: FreeDecay) -> Callable[[Array], Array]:
    """Return the function that gives the variance, by frequency, of the displacement that all channels together give."""
    powers = {"displacement": 0, "velocity": 2, "acceleration": 4}
    levels = noise_levels(decay)
    if "displacement" in levels:
        levels.pop("velocity", None)  # the motion is made without it

    def spectrum(w: Array) -> Array:
        information = sum(w ** powers[name] / level**2 for name, level in levels.items())
        return np.asarray(1 / information)

    return spectrum


def window_of(decay: FreeDecay, motion: Motion) -> ForceWindow:
    """Return the window of a motion: after the release is over, above sticking and noise; all of it where a force drives it.

    Raises NotIdentifiable when it holds no oscillation or too few cycles.
    """
    first, stop, w = usable(decay, motion, noise_levels(decay), _FEWEST_CYCLES)
    if "and" not in motion.source and (coarse := too_coarse(motion.displacement, motion.rate, 0)):
        raise NotIdentifiable(coarse)
    force = None if decay.force is None else decay.force[motion.start :]
    return ForceWindow(motion, first, stop, motion.valid[first:stop], w, force, noise_spectrum(decay))


def points_of(window: ForceWindow) -> NDArray[np.int_]:
    """Samples of the window whose force and sign of velocity can be trusted, as indices into the motion."""
    v = window.cut(window.motion.velocity)
    turned = np.zeros(len(v), dtype=np.bool_)
    reversal = np.flatnonzero(v[1:] * v[:-1] <= 0)
    reach = min(_REACH, int(0.05 * 2 * np.pi * window.motion.rate / window.angular_frequency))
    for shift in range(1 - reach, reach + 1):
        turned[np.clip(reversal + shift, 0, len(v) - 1)] = True
    least = _SURE_SIGN * window.motion.noise_velocity
    return np.asarray(window.first + np.flatnonzero(window.valid & ~turned & (np.abs(v) > least)))
