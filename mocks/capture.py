"""One capture on the board, START to END: what was sampled, what waits, what is kept for RESEND."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol
from zlib import crc32

import numpy as np

from firmware_protocol import ChannelDescription, Data, End, Event, EventKind, SampleFormat
from mocks.misconfigurations import Misconfiguration

FORMATS: dict[SampleFormat, np.dtype[Any]] = {
    SampleFormat.I16: np.dtype("<i2"),
    SampleFormat.I32: np.dtype("<i4"),
    SampleFormat.F32: np.dtype("<f4"),
    SampleFormat.F64: np.dtype("<f8"),
}
BUFFER_S = 2.0  # Unsent samples that fit before the board drops some.
LONGEST_WAIT_S = 0.1
FULL_CODE = 32767


class Source(Protocol):
    """What the board samples."""

    def take(self, count: int) -> np.ndarray:
        """Return the next `count` samples, (count, channels) codes."""


@dataclass(frozen=True)
class Settings:
    """What CONFIG sets."""

    rate: float = 256.0
    samples_per_frame: int = 16
    format: SampleFormat = SampleFormat.I16


class Capture:
    """The samples of one capture. `count` 0 means until STOP; `memory_s` is what RESEND can ask for."""

    def __init__(
        self,
        source: Source,
        settings: Settings,
        channels: tuple[ChannelDescription, ...],
        misconfiguration: Misconfiguration,
        started_us: int,
        count: int,
        memory_s: float,
        pace: float,
    ) -> None:
        self.count = count
        self.sampled = 0
        self.dropped = 0
        self.settings = settings
        self._source = source
        self._channels = channels
        self._misconfiguration = misconfiguration
        self._started_us = started_us
        self._memory = int(memory_s * settings.rate)
        self._capacity = max(64, int(BUFFER_S * settings.rate * max(1.0, pace)))
        longest = max(LONGEST_WAIT_S, misconfiguration.frame_s)
        self._least = min(settings.samples_per_frame, max(1, int(longest * settings.rate)))
        self._unsaid = 0
        self._checksum = 0
        self._warned = -(10**9)
        self._waiting: deque[tuple[int, int, np.ndarray]] = deque()
        self._kept: deque[tuple[int, np.ndarray]] = deque()

    @property
    def unsent(self) -> int:
        """Samples that wait to be sent."""
        return sum(len(codes) for _, _, codes in self._waiting)

    @property
    def fill_percent(self) -> int:
        """How full the buffer of unsent samples is."""
        return min(100, 100 * self.unsent // self._capacity)

    @property
    def complete(self) -> bool:
        """Whether the samples that START asked for have been taken."""
        return bool(self.count) and self.sampled >= self.count

    def take(self, due: int) -> list[Event]:
        """Sample `due` times; keep what fits, drop the rest, and return the events."""
        if self.count:
            due = min(due, self.count - self.sampled)
        if due <= 0:
            return []
        codes = self._misconfiguration.codes(self._source.take(due), self.sampled, self.settings.rate)
        events = self._saturation(codes)
        first = self._misconfiguration.index(self.sampled)
        self.sampled += due
        kept = codes[: max(0, self._capacity - self.unsent)]
        if len(kept):
            self._waiting.append((first, self._unsaid, kept))
            self._kept.append((first, kept))
            self._unsaid = 0
            self._forget()
        lost = due - len(kept)
        if lost and not self._unsaid:
            text = "the host takes too few samples"
            events.append(Event(EventKind.OVERRUN, self.sampled - lost, lost, text=text))
        self._unsaid += lost
        self.dropped += lost
        return events

    def next_data(self, last: bool) -> Data | None:
        """Return the next DATA that is full, or, when it is the `last` call, with what there is."""
        if not self._waiting or (not last and self.unsent < self._least):
            return None
        first, dropped, head = self._waiting.popleft()
        size = self.settings.samples_per_frame
        parts, have = [head[:size]], min(size, len(head))
        if len(head) > size:
            self._waiting.appendleft((first + size, 0, head[size:]))
        while have < size and self._waiting:
            follows, gap, more = self._waiting[0]
            if gap or follows != first + have:
                break
            self._waiting.popleft()
            parts.append(more[: size - have])
            if len(more) > size - have:
                self._waiting.appendleft((follows + size - have, 0, more[size - have :]))
            have += len(parts[-1])
        dropped += self._misconfiguration.dropped(first, have, self.settings.rate)
        data = self._data(first, dropped, np.concatenate(parts))
        self._checksum = crc32(data.samples, self._checksum)
        return data

    def again(self, first: int, count: int) -> Iterator[Data]:
        """Yield those of the samples asked for that are still kept, and more where the board is misconfigured."""
        more = self._misconfiguration.before_hole(first)
        if more:
            wrong = np.zeros((more, len(self._channels)), dtype=np.int32)
            yield self._data(first - more, 0, wrong)
        oldest = self.sampled - self._memory
        for start, codes in self._kept:
            a, b = max(first, start, oldest), min(first + count, start + len(codes))
            for at in range(a, b, self.settings.samples_per_frame):
                stop = min(at + self.settings.samples_per_frame, b)
                yield self._data(at, 0, codes[at - start : stop - start])

    def end(self) -> End:
        """Return the END of what has been sent."""
        return self._misconfiguration.end(End(self.sampled, self.dropped, self._checksum))

    def _data(self, first: int, dropped: int, codes: np.ndarray) -> Data:
        form = self.settings.format
        numbers = codes
        if form in (SampleFormat.F32, SampleFormat.F64):
            scale = np.array([c.scale for c in self._channels])
            numbers = codes * scale + np.array([c.offset for c in self._channels])
        since_us = int(first * 1e6 / (self.settings.rate * self._misconfiguration.time_stamp_rate))
        since_us += self._misconfiguration.time_us(first, self.settings.rate)
        payload = np.ascontiguousarray(numbers.astype(FORMATS[form])).tobytes()
        return Data(first, self._started_us + since_us, dropped, len(codes), codes.shape[1], form, payload)

    def _saturation(self, codes: np.ndarray) -> list[Event]:
        """Return an EVENT for each channel at the end of its range, four times a second at most."""
        if self._misconfiguration.no_range or self.sampled - self._warned < self.settings.rate / 4.0:
            return []
        events = []
        for channel in range(codes.shape[1]):
            full = np.nonzero((codes[:, channel] >= FULL_CODE) | (codes[:, channel] < -FULL_CODE))[0]
            if len(full):
                self._warned = self.sampled
                at = self.sampled + int(full[0])
                events.append(Event(EventKind.SATURATION, at, len(full), channel, "converter at its end"))
        return events

    def _forget(self) -> None:
        oldest = self.sampled - self._memory
        while self._kept and self._kept[0][0] + len(self._kept[0][1]) <= oldest:
            self._kept.popleft()
