"""The sensors: what stands between the true motion and the numbers of the converter."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter


@dataclass(frozen=True)
class Sensor:
    """One channel: white `noise` (rms), converter (`bits` over +-`full_scale`), `gain`, `offset`, `lag` s.

    A positive lag means that the channel is late: it shows at t what happened at t - lag.
    """

    noise: float = 0.0
    bits: int = 16
    full_scale: float = math.inf
    gain: float = 1.0
    offset: float = 0.0
    lag: float = 0.0

    @property
    def step(self) -> float:
        """Smallest difference that the converter resolves, 0 for an ideal one."""
        return 0.0 if math.isinf(self.full_scale) else 2.0 * self.full_scale / 2.0**self.bits

    def convert(self, signal: np.ndarray, random: np.random.Generator) -> np.ndarray:
        """Convert `signal`: gain, offset, noise, range and steps."""
        seen = self.gain * np.asarray(signal) + self.offset + self.noise * random.standard_normal(len(signal))
        return quantise(seen, self.bits, self.full_scale)


def quantise(signal: np.ndarray, bits: int, full_scale: float) -> np.ndarray:
    """Return `signal` clipped to +-`full_scale` and rounded to `bits`, two's complement."""
    if math.isinf(full_scale):
        return np.array(signal, dtype=float)
    step = 2.0 * full_scale / 2.0**bits
    half = 2 ** (bits - 1)
    return np.clip(np.rint(np.asarray(signal) / step), -half, half - 1) * step


def high_pass(signal: np.ndarray, interval: float, corner: float, before: float) -> np.ndarray:
    """Return a first-order high-pass of `signal`, exact for one that is straight between samples.

    `interval` s, `corner` Hz; `before` is the value the signal had for a long time before.
    """
    rate = 2.0 * math.pi * corner
    keep = math.exp(-rate * interval)
    ramp = (1.0 - keep) / (rate * interval)
    jumps = np.diff(signal, prepend=before) * ramp
    jumps[0] /= ramp  # The first sample is a step from `before`, not a ramp.
    out: np.ndarray = lfilter([1.0], [1.0, -keep], jumps)
    return out


def hold_samples(
    signal: np.ndarray, energy: float, first: int, random: np.random.Generator, kind: str = "hold"
) -> tuple[np.ndarray, list[tuple[int, int]]]:
    """Return `signal` with samples lost at random, and where: (index, count) of each loss.

    The sensor repeats its last value (`kind` "hold") or falls to zero ("zero") for 1 to 6
    samples. Losses are added from `first` on until their squared error sums to `energy`; one
    that would overshoot it by a tenth is not taken.
    """
    out = np.array(signal)
    lost: list[tuple[int, int]] = []
    taken = np.zeros(len(signal), dtype=bool)
    spent = 0.0
    for _ in range(20000):
        if spent >= 0.97 * energy:
            break
        count = int(random.integers(1, 7))
        at = int(random.integers(first, len(signal) - count))
        if taken[at - 1 : at + count + 1].any():
            continue
        value = signal[at - 1] if kind == "hold" else 0.0
        cost = float(np.sum((signal[at : at + count] - value) ** 2))
        if cost == 0.0 or spent + cost > 1.1 * energy:
            continue
        out[at : at + count] = value
        taken[at : at + count] = True
        lost.append((at, count))
        spent += cost
    return out, sorted(lost)
