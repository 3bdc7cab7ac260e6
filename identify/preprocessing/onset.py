"""The onset of free motion: where held turns into free, by a change-point fit of the two motions."""

from typing import Literal, NamedTuple

import numpy as np

from identify.arrays import Array

BEFORE, AFTER = 0.35, 0.45
"""Periods before and after the onset that the fit looks at: under a half-cycle, so no reversal falls in it."""

STRAY_SHARE = 0.1
"""A displaced release may show this share of damping's start, an impulse of a displacement, before it costs anything."""

MOST_CANDIDATES = 400

Beginning = Literal["displaced", "impulse"]


class Onset(NamedTuple):
    """The beginning of free motion, and its kind.

    `place` (fractional sample) and `std` (samples) of the onset; amplitudes of the two ways to begin.
    `misfit` is the mean square left; `misfit_without` what one oscillation and a line leave of the same samples.
    """

    place: float
    std: float
    displaced: float
    impulse: float
    misfit: float
    misfit_without: float


def locate(
    values: Array, period: float, derivative: int, around: float, reach: float, push: float = 0.0
) -> Onset | None:
    """Return the onset in `values` (n,) within `reach` samples of `around`, or None without room for one.

    Before the onset the channel is a straight line, after it the line plus free oscillation of `period`
    samples. `derivative` is 0 for a displacement, 1 for a velocity, 2 for an acceleration. Both ways to begin,
    from a displacement and with a velocity, are fitted; the one that explains more is kept. An acceleration is
    not looked at within `push` samples of an impulse: there it shows the blow itself.
    """
    best: Onset | None = None
    struck = derivative == 2 and _blow_is_seen(values, period, around, reach)
    kinds: tuple[Beginning, ...] = ("impulse",) if struck else ("displaced", "impulse")
    for kind in kinds:
        found = _search(values, period, derivative, around, reach, kind, push if struck else 0.0)
        if found is not None and (best is None or found.misfit < 0.8 * best.misfit):
            best = found
    return best


def _blow_is_seen(values: Array, period: float, around: float, reach: float) -> bool:
    """Check whether the acceleration near the onset stands well above what the oscillation then reaches."""
    first, last = int(max(around - reach, 0)), int(around + reach) + 2
    after = values[last : last + round(period)]
    if len(after) < 4 or last <= first:
        return False
    level = float(np.median(after))
    return float(np.max(np.abs(values[first:last] - level))) > 1.4 * float(np.max(np.abs(after - level)))


def _search(
    values: Array, period: float, derivative: int, around: float, reach: float, kind: Beginning, push: float
) -> Onset | None:
    """Scan the onset on finer and finer grids around the best so far, until its uncertainty ends the search."""
    centre, width = around, reach
    found: Onset | None = None
    for step in (max(1.0, period / 48.0), max(0.5, period / 400.0), 0.1, 0.02):
        after = AFTER if derivative or step > 0.6 else 0.5 * AFTER
        first = int(max(0, np.floor(centre - BEFORE * period - 3)))
        last = int(min(len(values), np.ceil(centre + max(after * period, 4) + 4)))
        candidates = np.arange(centre - width, centre + width + 0.5 * step, step)
        candidates = candidates[(candidates > first + 1.5) & (candidates < last - 4)]
        if last - first < 8 or not 0 < len(candidates) <= MOST_CANDIDATES:
            return found
        found = _best_of(values[first:last], candidates - first, period, derivative, kind, push, step)
        found = found._replace(place=found.place + first)
        centre, width = found.place, 2.5 * step if step > 0.6 else 10 * step
        if step <= 0.1 and found.std > 0.5:
            break
    return found


def _best_of(
    segment: Array, onsets: Array, period: float, derivative: int, kind: Beginning, push: float, step: float
) -> Onset:
    """The best of the candidate onsets, with the spread of those that fit as well within the noise."""
    misfits, coefficients = _fit_all(segment, onsets, period, derivative, kind, push)
    ties = np.flatnonzero(misfits <= misfits.min() * (1 + 1e-9))
    pick = int(ties[len(ties) // 2])
    noise = misfits[pick] / max(len(segment) - 5, 1)
    near = onsets[misfits < misfits[pick] + noise]
    displaced, impulse = (float(c) for c in coefficients[pick][2:])
    return Onset(
        place=float(onsets[pick]),
        std=max(float(np.ptp(near)) / 2.0, step / np.sqrt(12.0)),
        displaced=displaced,
        impulse=impulse if kind == "impulse" else 0.0,
        misfit=float(misfits[pick]) / len(segment),
        misfit_without=_without_onset(segment, period),
    )


def _fit_all(
    segment: Array, onsets: Array, period: float, derivative: int, kind: Beginning, push: float
) -> tuple[Array, Array]:
    """Penalised least squares for every candidate: sums of squares (m,), coefficients (m, 4).

    A line throughout, and after the onset the two ways to begin. The second of them is penalised in
    proportion to the first: alone it would stand for a shift of the onset.
    """
    time = np.arange(len(segment)) - onsets[:, None]
    seen = (np.abs(time) > push).astype(float) if push > 0.0 else np.ones_like(time)
    ways = _ways_to_begin(np.maximum(time, 0.0), period, derivative, kind)
    columns = np.stack([np.ones_like(time), time / period, *(way * (time >= 0) for way in ways)], axis=2)
    columns *= seen[:, :, None]
    looked_at = segment * seen
    squares = np.swapaxes(columns, 1, 2) @ columns
    products = np.einsum("mnk,mn->mk", columns, looked_at)
    main, stray = (2, 3) if kind == "displaced" else (3, 2)
    squares += 1e-12 * np.trace(squares, axis1=1, axis2=2)[:, None, None] * np.eye(4)
    for _ in range(2):
        coefficients = np.linalg.solve(squares, products[:, :, None])[:, :, 0]
        residual = looked_at - np.einsum("mnk,mk->mn", columns, coefficients)
        total = np.sum(residual**2, axis=1)
        spread = total / np.maximum(seen.sum(axis=1) - 4, 1) + 1e-300
        penalty = spread / np.maximum(STRAY_SHARE * np.abs(coefficients[:, main]), 1e-150) ** 2
        squares[:, stray, stray] += penalty
    total += penalty * coefficients[:, stray] ** 2
    return total * len(segment) / np.maximum(seen.sum(axis=1), 1.0), coefficients


def _ways_to_begin(time: Array, period: float, derivative: int, kind: Beginning) -> tuple[Array, Array]:
    """Free motion from a displacement, and with a velocity (or, after a displacement, damping's cubic start)."""
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
