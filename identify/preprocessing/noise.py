"""The noise floor: the white noise of each channel, from the rest before the release or from the band above the motion."""

from dataclasses import dataclass, replace
from math import comb

import numpy as np

from identify.arrays import Array, Mask
from identify.free_decay import FreeDecay
from identify.signal.smoothing import without_line
from identify.signal.spectrum import white_level

DIFFERENCE_ORDER = 6
SHORTEST_REST = 24
DITHERED = 0.5
"""Noise at rest, in steps of the converter, from which on it carries the readings over the steps and shows their error."""

_STILL, _UNSURE_STILL, _UNSURE = 0.1, 0.1, 0.2
"""A rest that moves by less than so many steps stands still; relative errors of the noise by such a rest and by others."""

CLIP, LEFT_INSIDE = 3.0, 0.97334
"""Outliers lie beyond so many standard deviations; the share of a normal variable's variance that lies within."""

_FEW_WHOLE, _MOST_DIFFERENCES = 0.25, 100_000
"""Share of differences without a lost reading below which divided ones are taken, and how many of these at most."""

SAME = 1e-9
"""Share of the range of the readings by which two of them may differ by rounding alone, in another unit or a simulation."""


@dataclass(frozen=True)
class Noise:
    """White-noise standard deviation of one channel, its standard error (same unit), and where it was read."""

    std: float
    uncertainty: float
    source: str


def noise_levels(decay: FreeDecay) -> dict[str, float]:
    """Return the noise of each channel: as the decay states it, or read off the record; never quite zero."""
    stated = {name: getattr(decay, f"noise_{name}") for name in decay.channels}
    measured = {} if all(stated.values()) else noise_of(decay)
    return {
        name: max(stated[name] or measured[name].std, 1e-9 * float(np.nanstd(values)), 1e-300)
        for name, values in decay.channels.items()
    }


def noise_of(decay: FreeDecay) -> dict[str, Noise]:
    """Return the noise of each channel present, by name (displacement, velocity, acceleration).

    From the rest before the release when it has at least 24 samples: the floor of its spectrum, so that a drift or
    hum does not count. Otherwise from the moving part: differences of sixth order, whose median size no smooth
    motion and no single jump can change; where readings are lost everywhere, from divided ones of those that are left.
    """
    valid = np.ones(len(decay), dtype=bool) if decay.valid is None else decay.valid
    result: dict[str, Noise] = {}
    for name, values in decay.channels.items():
        first, last = decay.rest
        rest = values[first:last][valid[first:last]]
        if len(rest) >= SHORTEST_REST:
            found = with_steps(floor_at_rest(rest), converter_step(values[valid]))
        else:
            found = floor_above_motion(values[decay.start :], valid[decay.start :])
        least = SAME * float(np.ptp(values[valid])) if valid.any() else 0.0
        if found.std < least:
            found = replace(found, std=least, uncertainty=max(found.uncertainty, 0.5 * least))
        result[name] = found
    return result


def with_steps(at_rest: Noise, step: float) -> Noise:
    """Return the noise along the motion of a converter with this step, from the noise at rest.

    Noise of half a step or more carries a resting reading over the steps, and shows their error. Less of it does not: the
    error of the steps, their size over the square root of twelve along any motion (Bennett 1948), is not in the rest.
    """
    if at_rest.std >= DITHERED * step:
        return at_rest
    std = float(np.hypot(at_rest.std, step / np.sqrt(12.0)))
    share = _UNSURE_STILL if at_rest.std < _STILL * step else _UNSURE
    return Noise(std, share * std, f"{at_rest.source}, and the converter's steps")


def floor_at_rest(rest: Array) -> Noise:
    """Return the floor of the spectrum of a channel at rest: drift and lines are left out of it."""
    n = len(rest)
    taper = np.sin(np.pi * (np.arange(n) + 0.5) / n)
    power = np.abs(np.fft.rfft(without_line(rest) * taper)) ** 2 / np.sum(taper**2)
    power = power[3 : len(power) - 1] if len(power) > 12 else power[1:]
    std = float(np.sqrt(white_level(power, 6.0)))
    return Noise(std, float(std / np.sqrt(2.3 * max(len(power), 1))), "rest before the release")


def floor_above_motion(values: Array, valid: Mask | None = None) -> Noise:
    """Return the floor from sixth differences, which a smooth motion leaves empty; outliers (jumps) are clipped off."""
    order = min(DIFFERENCE_ORDER, max(len(values) // 4, 1))
    size = np.abs(np.diff(values, order))
    if valid is not None and not valid.all():
        touched = np.convolve(~valid, np.ones(order + 1), "valid") > 0
        few = np.count_nonzero(~touched) < _FEW_WHOLE * len(touched)
        size = _beside_gaps(values, valid, order) if few else size[~touched]
    if len(size) == 0:
        return Noise(0.0, float("inf"), "too few samples")
    spread = float(np.median(size)) / 0.6745
    for _ in range(6):
        inside = size[size < CLIP * spread]
        spread = float(np.sqrt(np.mean(inside**2) / LEFT_INSIDE)) if len(inside) > len(size) // 2 else spread
    std = max(spread / np.sqrt(comb(2 * order, order)), converter_step(values) / np.sqrt(12.0))
    return Noise(std, std * 1.6 / np.sqrt(len(size)), "band above the motion")


def _beside_gaps(values: Array, valid: Mask, order: int) -> Array:
    """Return the sizes of divided differences of neighbouring valid readings, each as if of equal steps.

    Of white noise all have the same variance; none span more than twice as many readings as without gaps.
    """
    places = np.flatnonzero(valid)
    if len(places) <= order:
        return np.zeros(0)
    at = np.lib.stride_tricks.sliding_window_view(places, order + 1)
    at = at[at[:, -1] - at[:, 0] <= 2 * order]
    at = at[:: len(at) // _MOST_DIFFERENCES + 1]
    apart = (at[:, :, None] - at[:, None, :] + np.eye(order + 1)).prod(axis=2)
    weight = 1.0 / apart
    return np.asarray(
        np.abs(np.sum(weight * values[at], axis=1))
        / np.sqrt(np.sum(weight**2, axis=1))
        * np.sqrt(comb(2 * order, order))
    )


def converter_step(values: Array) -> float:
    """Return the smallest difference between two readings that is not rounding: a converter's step; 0 where none differ."""
    steps = steps_between(values)
    return float(steps.min()) if len(steps) else 0.0


def steps_between(values: Array) -> Array:
    """Return the steps between neighbouring levels of readings (n,), one fewer than there are levels, in their unit."""
    if not len(values):
        return values
    steps = np.diff(np.sort(values))
    return np.asarray(steps[steps > SAME * np.ptp(values)])


def stale(readings: Array) -> Mask:
    """Return which readings (n,) repeat the one before, or are zero."""
    rounding = SAME * float(np.ptp(readings))
    mask = np.asarray(np.abs(readings) <= rounding)
    mask[1:] |= np.abs(np.diff(readings)) <= rounding
    return mask
