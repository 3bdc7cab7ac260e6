"""The first steps of every identification: the release, the noise, lost readings, and the lag between the channels."""

from dataclasses import dataclass

from identify.arrays import Mask
from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.formatting import quantity
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import Alignment, align, correct
from identify.preprocessing.lost_readings import find_lost_readings, find_spikes
from identify.preprocessing.noise import Noise, noise_of
from identify.preprocessing.release import Release, release_of
from identify.summary import Summarised, Summary

MOST_LOST = 0.2
"""Share of a channel's readings above which they are its normal way of reading, a coarse converter's, and not lost."""


@dataclass(frozen=True, eq=False, repr=False)
class AlignedDecay(Summarised):
    """One release, located in its record, with its channels moved onto one clock.

    `recorded` is the decay as it was recorded, with `release`, `rest` and `noise_*` filled in; `noise` tells where each
    channel's noise was read. `lost` marks the readings of each channel that its sensor repeated or lost, shape (n,).
    `alignment` is None where there is nothing to align, and `not_aligned` says why. `decay` is what identification
    works on: lost readings not valid, the displacement (or velocity) moved by the lag, the acceleration divided by its
    gain.
    """

    recorded: FreeDecay
    release: Release
    noise: dict[str, Noise]
    lost: dict[str, Mask]
    alignment: Alignment | None
    not_aligned: str
    decay: FreeDecay

    def brief(self) -> Summary:
        """Summarize the release, the lag and the gain."""
        found, rows = self.alignment, []
        lines = [f"Released at {self.release.time_s:.4f} s ({self.release.kind}).", self.not_aligned]
        if found is not None:
            lag = Estimate(found.lag.value * 1e6, found.lag.std * 1e6, "us")
            lines.append(found.caution)
            rows = [
                ("lag of the displacement (or velocity)", quantity(lag)),
                ("gain of the acceleration", quantity(found.gain)),
            ]
        return Summary("Aligned decay", lines, ("quantity", "value"), rows)


def locate_and_align(decay: FreeDecay) -> AlignedDecay:
    """Locate the release, measure the noise, mark lost readings, and align the channels.

    Raises NotIdentifiable when nothing in the record oscillates freely.
    """
    release = release_of(decay)
    located = decay.with_(release=release.index, rest=release.rest)
    noise = noise_of(located)
    std = {name: max(found.std, 1e-300) for name, found in noise.items()}
    recorded = located.with_(**{f"noise_{name}": value for name, value in std.items()})
    lost = {name: find_lost_readings(getattr(recorded, name), value) for name, value in std.items()}
    lost = {name: mask for name, mask in lost.items() if mask.mean() < MOST_LOST}
    valid = recorded.known
    for mask in lost.values():
        valid &= ~mask
    if recorded.displacement is not None:
        free = slice(recorded.start, None)
        valid[free] &= ~find_spikes(recorded.displacement[free], valid[free], recorded.rate)
    usable = recorded.with_(valid=None if valid.all() else valid)
    try:
        alignment = align(usable)
    except NotIdentifiable as refusal:
        return AlignedDecay(recorded, release, noise, lost, None, str(refusal), usable)
    return AlignedDecay(recorded, release, noise, lost, alignment, "", correct(usable, alignment))


def aligned(decay: FreeDecay | AlignedDecay) -> FreeDecay:
    """Locate the release of a decay and align its channels; a decay whose release was located already is kept."""
    if isinstance(decay, AlignedDecay):
        return decay.decay
    return decay if decay.release is not None else locate_and_align(decay).decay
