"""Misconfigured boards: wrong wiring, wrong descriptions and wrong clocks, which no checksum catches."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from firmware_protocol import Describe, End, SampleFormat

#: The faults of the board on the command line (`saturation` and `bump` are built into the bench).
MISCONFIGURATIONS = {
    "wrong-version": "speaks major version 2",
    "wrong-rate": "samples 1 % (or AMOUNT) faster than described",
    "wrong-description": "describes a format and a channel that DATA does not have",
    "wrong-counter": "indices jump by 7, the checksum of END is wrong",
    "clock-200ppm": "the board's clock is 200 ppm (or AMOUNT) fast",
    "saturation": "accelerometer with a range of 8 m/s^2 (or AMOUNT)",
    "dead-channel": "channel 1 (or AMOUNT) reads nothing but zero",
    "swapped": "the two sensors are wired to each other's input",
    "reversed": "the accelerometer is mounted the wrong way round",
    "bump": "somebody bumps the table while the mass is held",
}


@dataclass
class Misconfiguration:
    """What is wrong with one board; nothing by default.

    `rate` true rate over the described one, `clock` the board's clock over a true one, `time_stamp_rate`
    the true rate over the described one by the board's own time stamps.
    """

    wrong_version: bool = False
    rate: float = 1.0
    clock: float = 1.0
    time_stamp_rate: float = 1.0
    describe: bool = False
    counter: bool = False
    swapped: bool = False
    reversed: bool = False
    dead_channel: int | None = None

    def codes(self, codes: np.ndarray) -> np.ndarray:
        """Return the codes as a wrong wiring gives them."""
        out = codes.copy()
        if self.reversed:
            out[:, 1] = np.clip(-out[:, 1], -32768, 32767)
        if self.swapped:
            out = out[:, ::-1].copy()
        if self.dead_channel is not None:
            out[:, self.dead_channel] = 0
        return out

    def index(self, first: int) -> int:
        """Return the index sent for a sample: from the third second on, 7 too high."""
        return first + 7 if self.counter and first > 700 else first

    def end(self, end: End) -> End:
        """Return the END that is sent."""
        return replace(end, checksum=end.checksum ^ 1) if self.counter else end

    def description(self, describe: Describe) -> Describe:
        """Return the DESCRIBE that is sent: twice as wide numbers, and a channel too many."""
        if not self.describe:
            return describe
        form = SampleFormat.I32 if describe.format is SampleFormat.I16 else SampleFormat.I16
        return Describe(form, (*describe.channels, describe.channels[-1]))
