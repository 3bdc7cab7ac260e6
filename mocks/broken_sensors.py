"""Sensors that break during a capture: what becomes of the codes of a converter from then on, or now and then.

Written NAME[:AMOUNT[:CHANNEL]]; CHANNEL is displacement, acceleration or both, both unless given.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

#: name -> (default amount, what it is)
BROKEN_SENSORS = {
    "stuck": (0.5, "readings stand still for so many seconds, 5 s after START"),
    "repeats": (5.0, "of so many readings one is that before it"),
    "gain-change": (0.5, "the gain changes by this factor, 5 s after START"),
    "sign-change": (0.0, "the sign changes, 5 s after START; no amount"),
    "flat-top": (0.6, "the signal is cut off at this share of its largest swing; no range says so"),
    "wraps": (0.6, "the number wraps round at this share of the largest swing"),
    "spikes": (5.0, "so many readings of the motion leap by half its largest swing"),
}
CHANNELS = ("displacement", "acceleration")
STRIKES_S = 5.0
SPIKE_SPAN_S = 2.0


@dataclass
class BrokenSensor:
    """One fault of the channels at fault, numbers of columns; `largest` are the largest codes of the motion, by column."""

    name: str
    amount: float
    columns: tuple[int, ...]
    largest: tuple[float, ...]
    seed: int
    held: dict[int, int] = field(default_factory=dict)

    def read(self, codes: np.ndarray, first: int, rate: float) -> np.ndarray:
        """Return the codes, (n, 2), of the samples from `first` on as the broken converter gives them."""
        out = codes.copy()
        at = np.arange(first, first + len(codes))
        for column in self.columns:
            out[:, column] = self._column(codes[:, column], at, rate, column)
        return out

    def _column(self, codes: np.ndarray, at: np.ndarray, rate: float, column: int) -> np.ndarray:
        struck, size = at >= STRIKES_S * rate, self.largest[column]
        if self.name == "stuck":
            within = struck & (at < (STRIKES_S + self.amount) * rate)
            return self._holding(codes, within, column)
        if self.name == "repeats":
            return self._holding(codes, at % round(self.amount) == 0, column)
        if self.name == "gain-change":
            return np.where(struck, np.rint(self.amount * codes), codes).astype(np.int32)
        if self.name == "sign-change":
            return np.where(struck, -codes, codes)
        if self.name == "flat-top":
            return np.asarray(np.clip(codes, -round(self.amount * size), round(self.amount * size)))
        if self.name == "wraps":
            half = round(self.amount * size)
            return np.asarray((codes + half) % (2 * half) - half)
        random = np.random.default_rng([self.seed, 11, column])
        where = np.rint((STRIKES_S + SPIKE_SPAN_S * (random.random(round(self.amount)) - 0.5)) * rate)
        sign = 1 if random.random() < 0.5 else -1
        return np.asarray(codes + np.isin(at, where) * round(0.5 * sign * size))

    def _holding(self, codes: np.ndarray, holds: np.ndarray, column: int) -> np.ndarray:
        """Return the codes where those marked are the last before them that is not."""
        out = codes.copy()
        for i in range(len(out)):
            if holds[i]:
                out[i] = self.held.get(column, out[i])
            self.held[column] = int(out[i])
        return out


def parse_broken(text: str, largest: tuple[float, ...], seed: int) -> BrokenSensor:
    """Return the fault of NAME[:AMOUNT[:CHANNEL]]; ValueError in words."""
    name, amount, channel = (*text.split(":"), "", "")[:3]
    if channel not in ("", "both", *CHANNELS):
        raise ValueError(f"--fault {text}: the channel is {', '.join(CHANNELS)} or both, not {channel!r}")
    try:
        value = float(amount) if amount else BROKEN_SENSORS[name][0]
    except ValueError:
        raise ValueError(
            f"a broken sensor is written NAME:AMOUNT:CHANNEL with a number, not {text!r}"
        ) from None
    columns = (CHANNELS.index(channel),) if channel in CHANNELS else (0, 1)
    return BrokenSensor(name, value, columns, largest, seed)
