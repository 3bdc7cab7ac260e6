"""The fit window: the part of a free decay that is fitted, and the noise that each reading has."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Self

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import CHANNELS
from identify.signal.coloured_noise import Colour, Whitening

_FEW_A_CYCLE = 24
"""Readings a cycle that show a law, and a second mass eight times as fast as the motion three times a cycle."""


@dataclass(frozen=True, eq=False)
class PreReleaseMotion:
    """The measured motion from the rest before the release to the first sample of the span, inclusive, SI, shape (m,).

    `time` counts from the release, `displacement` from the spring's zero. Effects with memory are driven along it.
    """

    time: Array
    displacement: Array
    velocity: Array


@dataclass(frozen=True)
class OwnLinear:
    """By how much the linear spring and damper of one release may differ from those of all releases.

    `stiffness` (1/s^2) and `damping` (1/s) are standard deviations; 0 where it may not differ. What they are off counts
    `weight` times, in units of the noise: more than once where a model leaves more than noise.
    """

    stiffness: float
    damping: float
    weight: float = 1.0


@dataclass(frozen=True, eq=False)
class FitWindow:
    """Readings of one release from the first sample that is compared, shape (n,) a channel, SI.

    `time` is the first sample's time since the release (s). `used` marks the readings that count; `sigma` is
    the noise of each channel; `lead` samples at the start are simulated but not compared, so that a late channel has a past.
    `lag` is where the search for the lag begins (s) and `lag_reach` how far it may go; `gain` is where that for the gain
    begins, which may be anything for a sensor turned over, or read in another unit. `gain_uncertainty` is what the
    calibration certificates leave open, and enters as a prior when the gain is judged. `pre_release` is None where the rest
    before the release was not seen. `force` is an external force per unit mass (m/s^2), None where none acts;
    where the mass was only estimated, `force_known` is False and its scale is fitted. A `segment` is one of several
    pieces of a long release, and `release` counts the releases that are fitted together. `rate_std` is the standard error
    of the rate (Hz), None when unknown. `colour` holds what the noise of a channel has beside its white part, in units of
    `sigma`. `own_linear` says by how much spring and damper of its release may differ from those of all; None where they
    are shared. `varies` names what was changed on purpose between the releases ("stiffness", "damping", "inertia"), and
    `lightness` is the inertia that all strengths are divided by over this release's.
    """

    rate: float
    time: float
    readings: dict[str, Array]
    used: dict[str, Mask]
    sigma: dict[str, float]
    lead: int
    lag: float = 0.0
    lag_reach: float = 0.0
    gain: float = 1.0
    gain_uncertainty: float = 0.0
    pre_release: PreReleaseMotion | None = None
    force: Array | None = None
    force_known: bool = True
    segment: bool = False
    unit: str = "m"
    colour: dict[str, Colour] = field(default_factory=dict)
    rate_std: float | None = None
    release: int = 0
    own_linear: OwnLinear | None = None
    varies: frozenset[str] = frozenset()
    lightness: float = 1.0

    def __len__(self) -> int:
        return len(next(iter(self.readings.values())))

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The channels present, in the order displacement, velocity, acceleration."""
        return tuple(c for c in CHANNELS if c in self.readings)

    @property
    def paired(self) -> bool:
        """Whether the acceleration stands beside a lower channel, so that lag and gain can be known."""
        return "acceleration" in self.readings and len(self.readings) > 1

    @property
    def estimates_mass(self) -> bool:
        """Whether a force of unknown scale acts, so that the mass is one of the unknowns."""
        return self.force is not None and not self.force_known

    @cached_property
    def clock(self) -> Array:
        """Time since the release of each sample, s."""
        return self.time + np.arange(len(self)) / self.rate

    @cached_property
    def _whitening(self) -> dict[str, Whitening]:
        return {c: Whitening(colour.components, self.rate, self.used[c]) for c, colour in self.colour.items()}

    def in_noise(self, channel: str, misfit: Array) -> Array:
        """Return a misfit (n,) of one channel, SI, in units of its noise, whitened; of readings not used it says nothing."""
        scaled = misfit / self.sigma[channel]
        whitening = self._whitening.get(channel)
        return scaled if whitening is None else whitening(scaled)

    def compared(self, channel: str, misfit: Array) -> Array:
        """Return a misfit (n,) of one channel, SI, in units of its noise, whitened, at the used readings alone."""
        return np.asarray(self.in_noise(channel, misfit)[self.used[channel]])

    def with_(self, **changes: object) -> Self:
        """Return a copy with some fields replaced."""
        return replace(self, **changes)  # type: ignore[arg-type]

    def part(self, samples: slice) -> Self:
        """Return some of the samples; with a step, the rate and the lead fall by it."""
        step = samples.step or 1
        return self.with_(
            rate=self.rate / step,
            rate_std=None if self.rate_std is None else self.rate_std / step,
            time=self.time + (samples.start or 0) / self.rate,
            readings={c: r[samples] for c, r in self.readings.items()},
            used={c: m[samples] for c, m in self.used.items()},
            lead=-(-self.lead // step),
            force=None if self.force is None else self.force[samples],
        )

    def thinned(self, step: int) -> Self:
        """Return every so many-th sample, each with the weight of them all: chi-square stays about what it is.

        A window with an external force stays whole: the force acts between the samples too.
        """
        if step < 2 or self.force is not None:
            return self
        if step not in self._thinned:
            self._thinned[step] = self.part(slice(None, None, step)).with_(
                sigma={c: sigma / np.sqrt(step) for c, sigma in self.sigma.items()},
                colour={c: colour.beside_white(1.0 / step) for c, colour in self.colour.items()},
            )
        return self._thinned[step]

    def at_few_readings(self, frequency: float) -> Self:
        """Return the window at some 24 readings a cycle of a motion of angular `frequency` (rad/s)."""
        return self.thinned(int(2.0 * np.pi / frequency * self.rate / _FEW_A_CYCLE))

    @cached_property
    def _thinned(self) -> dict[int, Self]:
        return {}


def windows_by_release(windows: Sequence[FitWindow]) -> dict[int, tuple[int, ...]]:
    """Return the places of the windows of each release, by its number."""
    found: dict[int, tuple[int, ...]] = {}
    for i, window in enumerate(windows):
        found[window.release] = (*found.get(window.release, ()), i)
    return found


def release_numbers(windows: Sequence[FitWindow]) -> tuple[list[int], int]:
    """Return the number of each window's release, from 0, and how many releases there are."""
    releases = list(windows_by_release(windows))
    return [releases.index(window.release) for window in windows], len(releases)
