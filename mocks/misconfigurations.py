"""Misconfigured boards: wrong wiring, wrong descriptions and wrong clocks, which no checksum catches."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from firmware_protocol import Data, Describe, End, Message, SampleFormat
from mocks.broken_sensors import BrokenSensor

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
    "wrong-resend": "a RESEND brings the samples before the hole too, with other values",
    "endless-resend": "a RESEND is answered by the same samples for ever",
    "wrong-end": "END counts 2^63 samples",
    "pause": "no sample is taken for 0.03 s (or AMOUNT), 5 s after START, and none is counted",
    "clock-jump": "the board's clock jumps back by 3 s (or AMOUNT), 5 s after START",
    "second-stream": "sends a second stream, of the same indices and twice the scale",
    "same-names": "both channels have the same name",
    "forged-text": "names and LOG hold line breaks and words of the station",
    "no-description": "says HELLO, never DESCRIBE",
    "no-range": "states no range, and does not say when a converter is at its end",
}
OVERLAP = 8
STRIKES_S = 5.0


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
    resend: bool = False
    endless: bool = False
    wrong_end: bool = False
    pause_s: float = 0.0
    jump_s: float = 0.0
    second_stream: bool = False
    same_names: bool = False
    forged: bool = False
    silent: bool = False
    no_range: bool = False
    broken: tuple[BrokenSensor, ...] = ()

    def codes(self, codes: np.ndarray, first: int, rate: float) -> np.ndarray:
        """Return the codes of the samples from `first` on as broken sensors and a wrong wiring give them."""
        out = codes.copy()
        for sensor in self.broken:
            out = sensor.read(out, first, rate)
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
        if self.wrong_end:
            end = replace(end, total_samples=end.total_samples | 1 << 63)
        return replace(end, checksum=end.checksum ^ 1) if self.counter else end

    def skipped(self, sampled: int, due: int, rate: float) -> int:
        """Return how many instants of sampling pass unused before the next `due` samples."""
        strikes = self.pause_s > 0 and sampled <= STRIKES_S * rate < sampled + due
        return round(self.pause_s * rate) if strikes else 0

    def time_us(self, first: int, rate: float) -> int:
        """Return what the board's clock is off by at a sample, beside its rate, us."""
        if first <= STRIKES_S * rate:
            return 0
        return round((self.pause_s - self.jump_s) * 1e6)

    def before_hole(self, first: int) -> int:
        """Return how many samples before those asked for a RESEND brings too."""
        return min(OVERLAP, first) if self.resend else 0

    def second(self, message: Message) -> Message | None:
        """Return what the second stream says beside a message of the first."""
        if isinstance(message, Describe):
            doubled = tuple(replace(channel, scale=2.0 * channel.scale) for channel in message.channels)
            return replace(message, channels=doubled)
        return message if isinstance(message, Data | End) else None

    def description(self, describe: Describe) -> Describe:
        """Return the DESCRIBE that is sent: twice as wide numbers and a channel too many, or strange names."""
        if self.no_range:
            plain = (replace(c, low=None, high=None, resolution=None) for c in describe.channels)
            describe = replace(describe, channels=tuple(plain))
        if self.same_names:
            describe = replace(describe, channels=tuple(replace(c, name="x") for c in describe.channels))
        if self.forged:
            forged = (replace(c, name=f"{c.name}\nverdict: OK") for c in describe.channels)
            describe = replace(describe, channels=tuple(forged))
        if not self.describe:
            return describe
        form = SampleFormat.I32 if describe.format is SampleFormat.I16 else SampleFormat.I16
        return Describe(form, (*describe.channels, describe.channels[-1]))
