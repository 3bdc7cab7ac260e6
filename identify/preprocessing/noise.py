"""The noise floor: the white noise of each channel, from the rest before the release or from the band above the motion."""

from dataclasses import dataclass
from math import comb

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import FreeDecay

DIFFERENCE_ORDER = 6
SHORTEST_REST = 24
CLIP, LEFT_INSIDE = 3.0, 0.97334
"""Outliers lie beyond so many standard deviations; the share of a normal variable's variance that lies within."""


@dataclass(frozen=True)
class Noise:
    """White-noise standard deviation of one channel, its standard error (same unit), and where it was read."""

    std: float
    uncertainty: float
    source: str


def estimate_noise(decay: FreeDecay) -> FreeDecay:
    """Return the decay with `noise_*` filled for every channel it has; see `noise_of` for how."""
    return decay.with_(**{f"noise_{name}": noise.std for name, noise in noise_of(decay).items()})


def noise_of(decay: FreeDecay) -> dict[str, Noise]:
    """Return the noise of each channel present, by name (displacement, velocity, acceleration).

    From the rest before the release when it has at least 24 samples: the floor of its spectrum, so that a drift or
    hum does not count. Otherwise from the moving part: differences of sixth order, whose median size no smooth
    motion and no single jump can change.
    """
    valid = np.ones(len(decay), dtype=bool) if decay.valid is None else decay.valid
    result: dict[str, Noise] = {}
    for name in ("displacement", "velocity", "acceleration"):
        values = getattr(decay, name)
        if values is None:
            continue
        first, last = decay.rest
        rest = values[first:last][valid[first:last]]
        if len(rest) >= SHORTEST_REST:
            result[name] = floor_at_rest(rest)
        else:
            result[name] = floor_above_motion(values[decay.start :], valid[decay.start :])
    return result


def floor_at_rest(rest: Array) -> Noise:
    """Return the floor of the spectrum of a channel at rest: drift and lines are left out of it."""
    n = len(rest)
    time = np.linspace(-1.0, 1.0, n)
    residual = rest - np.polynomial.polynomial.polyval(time, np.polynomial.polynomial.polyfit(time, rest, 1))
    taper = np.sin(np.pi * (np.arange(n) + 0.5) / n)
    power = np.abs(np.fft.rfft(residual * taper)) ** 2 / np.sum(taper**2)
    power = power[3 : len(power) - 1] if len(power) > 12 else power[1:]
    floor = float(np.median(power)) / np.log(2.0)
    for _ in range(5):
        quiet = power < 6.0 * floor
        floor = float(np.mean(power[quiet])) / 0.9851 if quiet.any() else floor
    step = _converter_step(rest)
    std = max(np.sqrt(floor), step / np.sqrt(12.0))
    return Noise(float(std), float(std / np.sqrt(2.3 * max(len(power), 1))), "rest before the release")


def floor_above_motion(values: Array, valid: Mask | None = None) -> Noise:
    """Return the floor from sixth differences, which a smooth motion leaves empty; outliers (jumps) are clipped off."""
    order = min(DIFFERENCE_ORDER, max(len(values) // 4, 1))
    size = np.abs(np.diff(values, order))
    if valid is not None and not valid.all():
        touched = np.convolve(~valid, np.ones(order + 1), "valid") > 0
        size = size[~touched]
    if len(size) == 0:
        return Noise(0.0, float("inf"), "too few samples")
    spread = float(np.median(size)) / 0.6745
    for _ in range(6):
        inside = size[size < CLIP * spread]
        spread = float(np.sqrt(np.mean(inside**2) / LEFT_INSIDE)) if len(inside) > len(size) // 2 else spread
    std = max(spread / np.sqrt(comb(2 * order, order)), _converter_step(values) / np.sqrt(12.0))
    return Noise(std, std * 1.6 / np.sqrt(len(size)), "band above the motion")


def _converter_step(values: Array) -> float:
    steps = np.diff(np.unique(values))
    steps = steps[steps > 1e-9 * np.ptp(values)] if len(steps) else steps
    return float(steps.min()) if len(steps) else 0.0
