"""What the board's converters read during one capture, sample by sample, sensor faults included."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocks import sensor_faults
from mocks.holder import Chunk
from mocks.operator_sequence import Episode
from mocks.sensor_faults import FILTERS, IMMEDIATE
from mocks.sensors import Sensor, high_pass
from mocks.testbed import Bench


@dataclass(frozen=True)
class Converter:
    """value = scale * code + offset; codes of `bits` bits, two's complement."""

    scale: float
    offset: float
    bits: int = 16

    def codes(self, values: np.ndarray) -> np.ndarray:
        """Return the codes, held at the ends of the range."""
        half = 2 ** (self.bits - 1)
        return np.clip(np.rint((values - self.offset) / self.scale), -half, half - 1).astype(np.int32)


class Acquisition:
    """Codes of displacement and acceleration at `rate` (Hz, the true one), in order."""

    def __init__(
        self,
        bench: Bench,
        episodes: Iterator[Episode | Chunk],
        rate: float,
        sensors: tuple[Sensor, Sensor],
        converters: tuple[Converter, Converter],
        faults: Mapping[str, Mapping[str, Any]],
        random: np.random.Generator,
        released: Callable[[Episode | Chunk, float], None],
        late_s: Callable[[np.ndarray, float], np.ndarray],
    ) -> None:
        self._bench = bench
        self._episodes = episodes
        self._rate = rate
        self._sensors = sensors
        self._converters = converters
        self._faults = faults
        self._random = random
        self._released = released
        self._late_s = late_s
        self._ready = [np.empty(0, dtype=np.int32), np.empty(0, dtype=np.int32)]
        self._made = [0, 0]
        self._taken = 0
        self._before: dict[tuple[int, str], float] = {}  # Input of each channel's high-pass, by fault.
        self._passed: dict[tuple[int, str], float] = {}  # Its output.
        self._coming: list[tuple[float, Episode | Chunk]] = []

    def take(self, count: int) -> np.ndarray:
        """Return the next `count` samples, (count, 2) codes."""
        while min(len(ready) for ready in self._ready) < count:
            self._make(next(self._episodes))
        out = np.stack([ready[:count] for ready in self._ready], axis=1)
        self._ready = [ready[count:] for ready in self._ready]
        self._taken += count
        while self._coming and self._coming[0][0] < self._taken:
            sample, episode = self._coming.pop(0)
            self._released(episode, sample)
        return out

    def _make(self, episode: Episode | Chunk) -> None:
        times = []
        for channel, sensor in enumerate(self._sensors):
            end = int(np.ceil((episode.end + sensor.lag) * self._rate))
            index = np.arange(self._made[channel], max(end, self._made[channel]))
            time = index / self._rate + self._late_s(index, self._rate)
            times.append(time[: np.searchsorted(time, episode.end + sensor.lag)])
            self._made[channel] += len(times[-1])
        lags = [sensor.lag for sensor in self._sensors]
        seen = episode.observe(self._bench, times[0] - lags[0], times[1] - lags[1])
        for channel in (0, 1):
            codes = self._convert(channel, seen[channel], times[channel])
            self._ready[channel] = np.concatenate([self._ready[channel], codes])
        if episode.release is not None:
            self._coming.append((episode.released_at * self._rate, episode))

    def _convert(self, channel: int, true: np.ndarray, time: np.ndarray) -> np.ndarray:
        sensor = self._sensors[channel]
        signal = sensor.gain * true
        name = ("displacement", "acceleration")[channel]
        mine = {fault: p for fault, p in self._faults.items() if p["channel"] == name}
        for fault, parameters in mine.items():
            if fault in IMMEDIATE:
                signal = signal + sensor_faults.error(fault, parameters, signal, time)
            elif fault in FILTERS and len(signal):
                passed = self._high_pass((channel, fault), parameters["fc"], signal)
                signal = signal - passed if fault == "sensor_bandwidth" else passed
        noise = sensor.noise * self._random.standard_normal(len(signal))
        codes = self._converters[channel].codes(signal + sensor.offset + noise)
        if "dropouts" in mine:
            codes = self._drop(codes, len(mine["dropouts"]["lost"]) / 8.0)
        return codes

    def _high_pass(self, key: tuple[int, str], corner: float, signal: np.ndarray) -> np.ndarray:
        """High-pass across calls: the filter is linear, so its old charge just decays on top."""
        start = self._before.get(key, float(signal[0]))
        decay = np.exp(-2.0 * np.pi * corner * np.arange(1, len(signal) + 1) / self._rate)
        ramped = np.concatenate([[start], signal])
        out = high_pass(ramped, 1.0 / self._rate, corner, start)[1:] + self._passed.get(key, 0.0) * decay
        self._before[key] = float(signal[-1])
        self._passed[key] = float(out[-1])
        return np.asarray(out)

    def _drop(self, codes: np.ndarray, per_second: float) -> np.ndarray:
        """Repeat the last code for 1 to 6 samples, `per_second` times a second on average."""
        out = codes.copy()
        for _ in range(self._random.poisson(per_second * len(codes) / self._rate)):
            count = int(self._random.integers(1, 7))
            if len(codes) > count + 1:
                at = int(self._random.integers(1, len(codes) - count))
                out[at : at + count] = out[at - 1]
        return out
