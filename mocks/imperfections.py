"""Ordinary imperfections of sensors that are no fault: coloured noise, lines, a slight bend, a finite bandwidth.

Sizes are in units of the channel's white noise, so that they are as ordinary at every working point.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.signal import lfilter

ONE_OVER_F, RANDOM_WALK, HUM, ALIASED_LINE, BEND, BANDWIDTH = (
    "one_over_f",
    "random_walk",
    "hum",
    "aliased_line",
    "bend",
    "bandwidth",
)
IMPERFECTIONS = (ONE_OVER_F, RANDOM_WALK, HUM, ALIASED_LINE, BEND, BANDWIDTH)

WALK = 2.0
"""White-noise standard deviations that a random walk strays in 256 samples."""
HUM_SIZE, LINE_SIZE = 3.0, 2.0
"""Amplitudes of hum and of an aliased line, in standard deviations of the white noise."""
BENT = 1e-3
"""Share of the peak by which a bent sensor is wrong at the peak."""
MAINS, SLOW = 50.0 / 256.0, 100.0 / 256.0
"""Frequency of the hum, and corner of a slow sensor, in cycles a sample."""


def check(names: tuple[str, ...]) -> None:
    """ValueError for what is no imperfection."""
    unknown = sorted(set(names) - set(IMPERFECTIONS))
    if unknown:
        raise ValueError(
            f"no imperfection is called {', '.join(unknown)}; there are: {', '.join(IMPERFECTIONS)}"
        )


def noise_of(
    names: tuple[str, ...],
    channel: str,
    samples: int,
    seed: int,
    channels: tuple[str, ...],
    pair: int | None = None,
) -> np.ndarray:
    """Draw the noise that the imperfections add to a channel, (samples,), in units of its white noise.

    `seed` draws the noise of this recording, `pair` (the seed where None) which sensor strays and the frequencies of lines.
    """
    check(names)
    pair = seed if pair is None else pair
    random = np.random.default_rng([seed, 6, channels.index(channel)])
    common = np.random.default_rng([pair, 7])
    at = channels[int(common.integers(len(channels)))]
    total = np.zeros(samples)
    if ONE_OVER_F in names:
        total += one_over_f(samples, random)
    if RANDOM_WALK in names and channel == at:
        total += WALK / math.sqrt(256.0) * np.cumsum(random.standard_normal(samples))
    if HUM in names:
        f = MAINS * (1.0 + 6e-4 * common.uniform(-1.0, 1.0))
        total += HUM_SIZE * np.sin(2.0 * math.pi * (f * np.arange(samples) + random.random()))
    if ALIASED_LINE in names and channel == at:
        f = np.random.default_rng([pair, 8]).uniform(0.03, 0.49)
        total += LINE_SIZE * np.sin(2.0 * math.pi * (f * np.arange(samples) + random.random()))
    return total


def one_over_f(samples: int, random: np.random.Generator) -> np.ndarray:
    """Return noise whose power falls as 1/f down to a quarter of the record's own frequency, of unit rms on average."""
    long = 4 * samples
    spectrum = random.standard_normal(long // 2 + 1) + 1j * random.standard_normal(long // 2 + 1)
    bins = np.arange(long // 2 + 1)
    spectrum[0] = 0.0
    weight = 1.0 / np.sqrt(np.maximum(bins, 1))
    weight[0] = 0.0
    signal = np.fft.irfft(spectrum * weight, long)
    expected = math.sqrt(4.0 * float(np.sum(weight**2))) / long
    return np.asarray(signal[:samples] / expected)


def distorted(
    names: tuple[str, ...],
    signal: Mapping[str, np.ndarray],
    fine: Mapping[str, np.ndarray],
    oversampling: int,
) -> dict[str, np.ndarray]:
    """Return the channels as a bent sensor of acceleration and a slow one of displacement show them.

    `fine` holds the displacement `oversampling` times as dense, where a slow sensor needs it.
    """
    check(names)
    out = dict(signal)
    if BEND in names:
        a = signal["acceleration"]
        out["acceleration"] = a + BENT * a**2 / float(np.max(np.abs(a)))
    if BANDWIDTH in names:
        u = fine["displacement"]
        keep = math.exp(-2.0 * math.pi * SLOW / oversampling)
        slow = lfilter([1.0 - keep], [1.0, -keep], u, zi=[keep * u[0]])[0]
        # The discrete low-pass is half a fine step early; at 16 fold that is 1/3000 of a cycle of the corner.
        out["displacement"] = out["displacement"] + (slow - u)[::oversampling]
    return out
