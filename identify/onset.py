"""The onset of free motion: where held turns into free, by a change-point fit of the two motions."""

from typing import NamedTuple

import numpy as np

from identify.arrays import Array

BEFORE, AFTER = 0.35, 0.45
"""Periods before and after the onset that the fit looks at: less than a half-cycle, so no reversal falls in it."""

STRAY_SHARE = 0.1
"""A displaced release may show this share of an impulse, and the other way round, before it costs anything."""


class Onset(NamedTuple):
    """`index` (fractional sample) and `std` (samples) of the onset; amplitudes of the two ways to begin; the level held.

    `misfit` is the mean square left; `misfit_without` what one oscillation and a line leave of the same samples.
    """

    index: float
    std: float
    displaced: float
    impulse: float
    level: float
    misfit: float
    misfit_without: float


def locate(
    values: Array, period: float, derivative: int, around: float, reach: float, push: float = 0.0
) -> Onset | None:
    """Return the onset in `values` (n,) within `reach` samples of `around`, or None when the record leaves no room.

    Before the onset the channel is a straight line, after it the line plus free oscillation of `period` samples.
    `derivative` is 0 for a displacement, 1 for a velocity, 2 for an acceleration. Both ways to begin, from a displacement
    and with a velocity, are fitted; the one that explains more is kept. An acceleration is not looked at within `push` samples of an impulse:
    there it shows the blow itself.
    """
    best: Onset | None = None
    struck = derivative == 2 and _blow_is_seen(values, period, around, reach)
    for kind in ("impulse",) if struck else ("displaced", "impulse"):
        found = _search(values, period, derivative, around, reach, kind, push if struck else 0.0)
        if found is not None and (best is None or found.misfit < 0.8 * best.misfit):
            best = found
    return best


def _blow_is_seen(values: Array, period: float, around: float, reach: float) -> bool:
    """Whether the acceleration near the onset stands well above what the oscillation then reaches."""
    first, last = int(max(around - reach, 0)), int(around + reach) + 2
    after = values[last : last + round(period)]
    if len(after) < 4 or last <= first:
        return False
    level = float(np.median(after))
    return float(np.max(np.abs(values[first:last] - level))) > 1.4 * float(np.max(np.abs(after - level)))


def _search(
    values: Array, period: float, derivative: int, around: float, reach: float, kind: str, push: float
) -> Onset | None:
    centre, width = around, reach
    found: Onset | None = None
    for step in (max(1.0, period / 48.0), max(0.5, period / 400.0), 0.1, 0.02):
        first = int(max(0, np.floor(centre - BEFORE * period - 3)))
        after = AFTER if derivative or step > 0.6 else 0.5 * AFTER
        last = int(min(len(values), np.ceil(centre + max(after * period, 4) + 4)))
        if last - first < 8:
            return found
        candidates = np.arange(centre - width, centre + width + 0.5 * step, step)
        candidates = candidates[(candidates > first + 1.5) & (candidates < last - 4)]
        if len(candidates) == 0:
            return found
        segment = values[first:last]
        fits = [_fit(segment, c - first, period, derivative, kind, push) for c in candidates]
        misfits = np.array([fit[0] for fit in fits])
        lowest = int(np.argmin(misfits))
        ties = np.flatnonzero(misfits <= misfits[lowest] * (1 + 1e-9))
        pick = int(ties[len(ties) // 2])
        _, coefficients = fits[pick]
        noise = misfits[pick] / max(len(segment) - 5, 1)
        near = candidates[misfits < misfits[pick] + noise]
        std = max(float(np.ptp(near)) / 2.0, step / np.sqrt(12.0))
        index = float(candidates[pick])
        found = Onset(
            index, std, float(coefficients[2]), float(coefficients[3]), float(coefficients[0]),
            float(misfits[pick]) / len(segment), _without_onset(segment, period),
        )  # fmt: skip
        if len(candidates) > 400:
            return found
        centre, width = index, 2.5 * step if step > 0.6 else 10 * step
        if step <= 0.1 and found.std > 0.5:
            break
    return found


def _fit(
    segment: Array, onset: float, period: float, derivative: int, kind: str, push: float
) -> tuple[float, Array]:
    """Penalised least squares of one line and the free motion after `onset`: the sum of squares, the coefficients."""
    time = np.arange(len(segment)) - onset
    free = time >= 0
    columns = np.column_stack(
        [np.ones(len(segment)), time / period, *_ways_to_begin(time * free, period, derivative, kind)]
    )
    columns[~free, 2:] = 0.0
    seen = np.abs(time) > push if push > 0.0 else np.ones(len(segment), dtype=bool)
    columns, looked_at = columns[seen], segment[seen]
    main, stray = (2, 3) if kind == "displaced" else (3, 2)
    coefficients, penalty = np.zeros(4), np.zeros(4)
    squares, products = columns.T @ columns, columns.T @ looked_at
    for _ in range(2):
        normal = squares + np.diag(penalty)
        coefficients = np.linalg.solve(normal + 1e-12 * np.trace(normal) * np.eye(4), products)
        residual = looked_at - columns @ coefficients
        spread = float(residual @ residual) / max(len(looked_at) - 4, 1) + 1e-300
        penalty[stray] = spread / max(STRAY_SHARE * abs(float(coefficients[main])), 1e-150) ** 2
    total = float(residual @ residual) + penalty[stray] * float(coefficients[stray]) ** 2
    return total * len(segment) / max(len(looked_at), 1), coefficients


def _ways_to_begin(time: Array, period: float, derivative: int, kind: str) -> tuple[Array, Array]:
    """Free motion from a displacement, and with a velocity (or, after a displacement, the cubic start of damping)."""
    phase = 2.0 * np.pi * time / period
    sine, cosine = np.sin(phase), np.cos(phase)
    displaced = (cosine - 1.0, -sine, -cosine)[derivative]
    if kind == "displaced":
        return displaced, (phase - sine, 1.0 - cosine, sine)[derivative]
    return displaced, (sine, cosine, -sine)[derivative]


def _without_onset(segment: Array, period: float) -> float:
    """Mean square left of the segment by one line and one oscillation throughout."""
    phase = 2.0 * np.pi * np.arange(len(segment)) / period
    columns = np.column_stack([np.ones(len(segment)), phase, np.cos(phase), np.sin(phase)])
    residual = segment - columns @ np.linalg.lstsq(columns, segment, rcond=None)[0]
    return float(residual @ residual) / len(segment)
