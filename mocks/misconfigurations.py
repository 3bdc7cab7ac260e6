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
    "index-stamps": "its time stamps are computed from the index, so that they know of no pause",
    "wander": "samples wander by 0.5 (or AMOUNT) of their spacing about even times, once in 4 s, and are stamped so",
    "jitter": "each sample is taken up to 0.45 (or AMOUNT) of its spacing early or late, and is stamped so",
    "long-frames": "sends DATA of 0.5 s (or AMOUNT)",
    "false-drop": "DATA says once that 1000 (or AMOUNT) samples were dropped where none is missing",
    "clock-says": "CLOCK states an error of 1e-300 ppm (or AMOUNT)",
    "second-stream": "sends a second stream, of the same indices and twice the scale",
    "same-names": "both channels have the same name",
    "forged-text": "names and LOG hold line breaks and words of the station",
    "no-description": "says HELLO, never DESCRIBE",
    "no-range": "states no range, and does not say when a converter is at its end",
}
OVERLAP = 8
STRIKES_S = 5.0
WANDER_S = 4.0


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
    index_stamps: bool = False
    wander: float = 0.0
    jitter: float = 0.0
    frame_s: float = 0.0
    false_drop: int = 0
    clock_says: float | None = None
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

    def late_s(self, index: np.ndarray, rate: float) -> np.ndarray:
        """Return how much later than at even times samples are really taken, s."""
        noise = np.modf(np.abs(np.sin(index * 12.9898) * 43758.5453))[0] - 0.5
        swing = self.wander * np.sin(2.0 * np.pi * index / (rate * WANDER_S)) + 2.0 * self.jitter * noise
        return np.asarray(swing / rate + np.where(index > STRIKES_S * rate, self.pause_s, 0.0))

    def taken(self, elapsed: float, rate: float) -> int:
        """Return how many samples have been taken some seconds after START: none in a pause."""
        before = min(elapsed, STRIKES_S)
        return int((before + max(elapsed - STRIKES_S - self.pause_s, 0.0)) * rate)

    def time_us(self, first: int, rate: float) -> int:
        """Return the error of the board's stamp of a sample, us."""
        late = 0.0 if self.index_stamps else float(self.late_s(np.array([first]), rate)[0])
        return round((late - (self.jump_s if first > STRIKES_S * rate else 0.0)) * 1e6)

    def dropped(self, first: int, count: int, rate: float) -> int:
        """Return how many samples DATA says were dropped before it beside those that were."""
        return self.false_drop if first <= STRIKES_S * rate < first + count else 0

    def before_hole(self, first: int) -> int:
        """Return how many samples before those asked for a RESEND brings too."""
        return min(OVERLAP, first) if self.resend else 0

    def second(self, message: Message) -> Message | None:
        """Return the message of the second stream beside one of the first; None for none."""
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
