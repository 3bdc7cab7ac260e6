"""P-values where nothing is hidden: uniform, or larger than that, if a small one is to mean what it says."""

import os
from concurrent.futures import ProcessPoolExecutor

import numpy as np

from identify.diagnosis.ranking import rank
from identify.diagnosis.search import chances, singles
from identify.fitting.baseline import fit_baseline
from identify.fitting.segments import prepared_of, segments_of
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from mocks.generate import draw

SECONDS, RATE = 4.0, 128.0
LEVELS = (0.02, 0.05, 0.1, 0.2, 0.5, 0.8)
KOLMOGOROV = 1.36
"""Largest distance of a sample's distribution from its own, times the root of its size, in 95 % of samples."""

WORKERS = int(os.environ.get("BENCH_WORKERS", "2"))


def p_value(seed: int) -> float:
    """Return the p-value of the best suspect of a small record with white noise in which nothing is hidden."""
    sample = draw(None, 0.0, seed, seconds=SECONDS, rate=RATE)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    baseline = fit_baseline(segments_of(prepared_of(decay)), base_model())
    chance = chances(baseline)
    return min(entry.p_value for entry in rank(baseline, singles(baseline, chance), chance))


def p_values(count: int, first: int = 70000) -> np.ndarray:
    """Return the p-values of so many records, sorted."""
    with ProcessPoolExecutor(WORKERS) as pool:
        return np.sort(list(pool.map(p_value, range(first, first + count))))


def distances(values: np.ndarray) -> tuple[float, float]:
    """Return by how much sorted p-values are too often small, and too often large: Kolmogorov's one-sided distances."""
    n = len(values)
    above = np.arange(1, n + 1) / n
    return float(np.max(above - values)), float(np.max(values - above + 1.0 / n))


def section(count: int) -> str:
    """Return the distribution of small records as markdown."""
    what = f"white noise: {count} records of {SECONDS:g} s at {RATE:g} Hz"
    return distribution(p_values(count), what)


def distribution(values: np.ndarray, what: str) -> str:
    """Return how many of sorted p-values are below each level, and how many should be, as a sentence."""
    small, large = distances(values)
    counts = ", ".join(
        f"{int(np.sum(values < level))} below {level:g} ({level * len(values):.3g} expected)"
        for level in LEVELS
    )
    return (
        f"P-value of the best suspect, nothing hidden, {what}: {counts}. Largest excess of small ones {small:.3f}, of large "
        f"ones {large:.3f} (Kolmogorov and Smirnov: below {KOLMOGOROV / np.sqrt(len(values)):.3f} in 95 % of samples)."
    )
