"""The direction of a motion, and when dry friction changes its sign: to a small part of a sample."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.signal.weak_form import Windows

_QUIET_CYCLES = 0.12  # to either side of a reversal, over which the velocity is a sine


@dataclass(frozen=True, eq=False)
class Direction:
    """The direction of motion between samples: `before` (n - 1,) is sgn v until the share `at` (n - 1,) of each interval."""

    before: Array
    at: Array


def direction_of(velocity: Array) -> Direction:
    """Return the direction of motion, with each reversal placed between two samples by the straight line."""
    moving = np.where(velocity == 0, 1e-12 * np.max(np.abs(velocity)) + 1e-300, velocity)
    before, after = moving[:-1], moving[1:]
    turns = np.sign(before) != np.sign(after)
    at = np.where(turns, before / np.where(turns, before - after, 1.0), 1.0)
    return Direction(np.sign(before), np.minimum(at, np.where(turns, 1 - 1e-9, 1.0)))


def refine_reversals(
    velocity: Array,
    direction: Direction,
    dry: float,
    drag: float,
    rate: float,
    angular_frequency: float,
    blur: int,
) -> Direction:
    """Return the direction with its reversals placed by the samples an eighth of a cycle to either side.

    Between reversals the velocity is a sine, of two amplitudes: before and after they differ by dry friction `dry`
    (m/s^2), from whose step at the reversal an oscillator answers with sin|a|/w at the angle a, and by quadratic damping
    `drag` (1/m), whose step sin^2 a it answers with 2/3 (1 - cos a) sin|a|/w. That difference is given back, and one sine
    with an offset is fitted across the reversal.
    `blur` samples next to the reversal are left out, where smoothing has rounded its kink.
    """
    reach = max(3, int(_QUIET_CYCLES * 2 * np.pi * rate / angular_frequency)) + blur
    turns = np.flatnonzero(direction.at < 1)
    inside = (turns >= reach) & (turns + 1 + reach < len(velocity))
    alone = np.diff(turns, prepend=-len(velocity)) > reach
    alone &= np.diff(turns, append=2 * len(velocity)) > reach
    turns = turns[inside & alone]
    if reach > 0.3 * 2 * np.pi * rate / angular_frequency or not len(turns):
        return direction
    at = direction.at.copy()
    offsets = np.concatenate([np.arange(-reach, 1 - blur), np.arange(1 + blur, reach + 2)])
    nearby = velocity[turns[:, None] + offsets]
    largest = 0.5 * (nearby[:, :1] - nearby[:, -1:]) / np.sin((reach + 0.5) * angular_frequency / rate)
    for _ in range(2):
        angle = (offsets - at[turns][:, None]) * (angular_frequency / rate)
        sine, cosine = np.sin(angle), np.cos(angle)
        force = dry + 2.0 / 3.0 * drag * largest**2 * (1.0 - cosine)
        smooth = nearby - direction.before[turns][:, None] * force / angular_frequency * np.abs(sine)
        # least squares on sin, cos and 1; at the reversal only the last two remain
        columns = np.stack([sine, cosine, np.ones_like(sine)], axis=2)
        normal = columns.transpose(0, 2, 1) @ columns
        found = np.linalg.solve(normal, columns.transpose(0, 2, 1) @ smooth[:, :, None])[:, :, 0]
        late = -(found[:, 1] + found[:, 2]) / found[:, 0] * (rate / angular_frequency)
        at[turns] = np.clip(at[turns] + np.where(np.abs(late) < 1, late, 0.0), 0.0, 1.0 - 1e-9)
    return Direction(direction.before, at)


def band_of_reversals(
    windows: Windows, width: int, direction: Direction, jump: float, velocity: Array, noise: float
) -> Array:
    """Return the covariance of the rows from not knowing when the motion turned, in lower banded form (width, 2w).

    A reversal is uncertain by the velocity's `noise` over its slope; friction of twice mu_0, the `jump`, is
    summed at the wrong moment for so long. Small amplitudes turn slowly, so their reversals count least.
    """
    turns = np.flatnonzero(direction.at < 1)
    late = noise / np.maximum(np.abs(velocity[turns + 1] - velocity[turns]), noise)
    at, place, seen = _windows_over(windows, turns.astype(np.float64))
    place = np.clip(place.astype(int), 0, windows.length - 1)
    share = np.where(seen, windows.derivative(0)[place], 0) * (jump * late)[:, None]
    parts = np.stack([share.real, share.imag], axis=2).reshape(len(turns), 2 * at.shape[1])
    rows = (2 * at[:, :, None] + np.arange(2)).reshape(parts.shape)
    band = np.zeros((width, 2 * len(windows.first)))
    for offset in range(min(width, parts.shape[1])):
        products = parts[:, offset:] * parts[:, : parts.shape[1] - offset]
        used = products != 0
        np.add.at(band[offset], rows[:, : parts.shape[1] - offset][used], products[used])
    return band


def rows_of_sign(windows: Windows, direction: Direction) -> Array:
    """Return the integral of phi sgn(v) over each window, real and imaginary parts in turn, shape (2w,).

    Exact for the reversals as they are placed, whatever the rate: the window's integral is evaluated there.
    """
    turns = np.flatnonzero(direction.at < 1)
    at, place, seen = _windows_over(windows, turns + direction.at[turns])
    steps = np.where(seen, 2 * direction.before[turns][:, None] * windows.integral(place), 0)
    length = windows.length
    last = np.minimum(windows.first + length - 1, len(direction.before) - 1)
    turned = direction.at[last] < np.minimum(windows.first + length - 0.5 - last, 1.0)
    end = np.where(turned, -1, 1) * direction.before[last]
    total = end * windows.integral(np.array(length - 0.5))
    np.add.at(total, np.clip(at, 0, len(total) - 1), steps)
    return np.stack([total.real, total.imag], axis=1).ravel()


def _windows_over(windows: Windows, moments: Array) -> tuple[NDArray[np.int_], Array, Mask]:
    """Windows that may hold each of the `moments` (k,), in samples.

    Their numbers, the moment's place in each, and whether it is inside, shape (k, m) each.
    """
    length = windows.length
    earliest = np.searchsorted(windows.first, moments - length + 0.5)
    number = earliest[:, None] + np.arange(length // windows.step + 1)
    known = np.minimum(number, len(windows.first) - 1)
    place = moments[:, None] - windows.first[known]
    seen = (number < len(windows.first)) & (place > -0.5) & (place < length - 0.5)
    return known, place, seen
