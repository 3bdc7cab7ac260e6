"""The contents of an exported file: the samples on one clock, their names and units, and their source."""

import re
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from daq.plain_text import distinct
from daq.recording import Array, Channel, Recording

NUMBERS = ("calibration_uncertainty", "resolution", "low", "high")
"""What is known of a channel in numbers."""


@dataclass(frozen=True, eq=False)
class Exported:
    """A recording with what is known of it: `facts` are short texts by name (session, operator, mass, lag ...)."""

    recording: Recording
    facts: dict[str, str] = field(default_factory=dict)

    @property
    def time(self) -> Array:
        """Time of each sample since the first, shape (n,), s."""
        return np.arange(len(self.recording.valid)) / self.recording.rate

    @property
    def samples(self) -> Array:
        """The samples, shape (channels, n), in SI units; NaN where they were lost."""
        return np.asarray(np.where(self.recording.valid, self.recording.samples, np.nan))

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """The channels, each by a name that is unlike the others, and that every format takes as a variable's name.

        The first channel of a quantity, which identification uses, has the quantity's name.
        """
        plain = (
            _identifier(c.name) if c.quantity == "other" else c.quantity for c in self.recording.channels
        )
        names = distinct(plain, "_", taken=("time", "valid"))
        return dict(zip(names, self.recording.channels, strict=True))

    @property
    def all_facts(self) -> dict[str, str]:
        """Facts of the recording itself, then those that were given."""
        recording = self.recording
        own = {"rate_hz": f"{recording.rate!r}"}
        if recording.rate_std is not None:
            own["rate_std_hz"] = f"{recording.rate_std!r}"
        own["samples_lost"] = str(int((~recording.valid).sum()))
        return own | self.facts

    def channel_facts(self, channel: Channel) -> dict[str, str]:
        """Describe a channel and its calibration in short texts, by name."""
        known = {
            "quantity": channel.quantity,
            "unit": channel.unit,
            "recorded_as": channel.name,
            "sensor": channel.sensor,
        }
        known |= {name: repr(value) for name in NUMBERS if (value := getattr(channel, name)) is not None}
        return {name: text for name, text in known.items() if text}


def _identifier(text: str) -> str:
    plain = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_")[:24].lower()
    return plain if plain[:1].isalpha() else f"channel_{plain}".rstrip("_")
