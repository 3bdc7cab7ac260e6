"""The direction of a motion, and when dry friction changes its sign: to a small part of a sample."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.weak_form import Windows

_QUIET_CYCLES = 0.12  # to either side of a reversal, over which the velocity is a sine


@dataclass(frozen=True, eq=False)
class Direction:
    """The direction of motion between samples: `before` (n - 1,) is sgn v until the share `at` (n - 1,) of each interval."""

    before: Array
    at: Array


def direction_of(velocity: Array) -> Direction:
    """Return the direction of motion, with each reversal placed between two samples by the straight line."""
    before, after = velocity[:-1], velocity[1:]
    turns = before * after < 0
    at = np.where(turns, before / np.where(turns, before - after, 1.0), 1.0)
    return Direction(np.where(before != 0, np.sign(before), np.sign(after)), at)


def refine_reversals(
    velocity: Array, direction: Direction, dry: float, rate: float, angular_frequency: float
) -> Direction:
    """Return the direction with its reversals placed by the samples an eighth of a cycle to either side.

    Between reversals the velocity is a sine, of two amplitudes: before and after they differ by dry friction
    `dry` (m/s^2). That difference is given back, and one sine with an offset is fitted across the reversal.
    """
    reach = int(_QUIET_CYCLES * 2 * np.pi * rate / angular_frequency)
    turns = np.flatnonzero(direction.at < 1)
    inside = (turns >= reach) & (turns + 1 + reach < len(velocity))
    alone = np.diff(turns, prepend=-len(velocity)) > reach
    alone &= np.diff(turns, append=2 * len(velocity)) > reach
    turns = turns[inside & alone]
    if reach < 3 or not len(turns):
        return direction
    at = direction.at.copy()
    offsets = np.arange(-reach, reach + 2)
    nearby = velocity[turns[:, None] + offsets]
    for _ in range(2):
        angle = (offsets - at[turns][:, None]) * (angular_frequency / rate)
        smooth = nearby - direction.before[turns][:, None] * dry / angular_frequency * np.sin(np.abs(angle))
        sine, cosine = np.sin(angle), np.cos(angle)
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
    place = turns[:, None] - windows.first
    seen = (place >= 0) & (place < len(windows.kernel))
    share = np.where(seen, windows.kernel[np.where(seen, place, 0)], 0) * (jump * late)[:, None]
    parts = np.stack([share.real, share.imag], axis=2).reshape(len(turns), -1)
    band = np.zeros((width, parts.shape[1]))
    for offset in range(min(width, parts.shape[1])):
        band[offset, : parts.shape[1] - offset] = np.einsum(
            "ki,ki->i", parts[:, offset:], parts[:, : parts.shape[1] - offset]
        )
    return band


def averaged_sign(direction: Direction) -> Array:
    """Return sgn v averaged under the hat of two sampling intervals around each sample, shape (n,).

    So the friction's jump is summed where it fell and not where the next sample is. The second difference makes up for what
    a straight line between the samples of a window misses of it.
    """
    sign, at = direction.before, direction.at
    out = np.zeros(len(sign) + 1)
    out[:-1] += sign * (2 * (at - 0.5 * at**2) - 0.5)
    out[1:] += sign * (at**2 - 0.5)
    out[0] *= 2
    out[-1] *= 2
    out[1:-1] -= (out[2:] - 2 * out[1:-1] + out[:-2]) / 12
    return out
