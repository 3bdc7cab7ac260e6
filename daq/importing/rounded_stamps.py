"""The rate behind time stamps that are coarser than the clock they come from."""

from collections.abc import Iterable

import numpy as np

from daq.recording import Array

MARGIN = 1e-6
FEWEST = 8
CAMERAS = (24000 / 1001, 30000 / 1001, 60000 / 1001)
CLEAR = 0.01  # Hz; three such errors are still far less than the distance between two nominal rates


def rate_within_rounding(index: Array, time: Array, steps: Array) -> tuple[float, float, float] | None:
    """Return period, time of sample 0 and the standard error of the period, by which every stamp is right once it is
    rounded, or cut off, to its step; None when no even clock is.

    `index` (n,), rising, are the samples, `time` (n,) their stamps in s and `steps` (n,) the roundings. All clocks that
    fit form a polygon of period and start: its middle is returned, with the error of a value that is evenly
    spread over the range of periods.
    """
    if len(index) < FEWEST or not np.all(steps > 0.0):
        return None
    for below, above in ((0.5, 0.5), (0.0, 1.0)):
        slack = MARGIN * steps
        found = _clocks(index, time - below * steps - slack, time + above * steps + slack)
        if found is not None:
            low, high, start = found
            return 0.5 * (low + high), start, (high - low) / np.sqrt(12.0)
    return None


def nominal_rate(rate: float, std: float) -> float | None:
    """Return the rate to which a camera or a logger was set, if one lies within three standard errors of `rate`: a
    whole number of Hz, or a camera's 23.976, 29.97, 59.94 Hz. None where the error is too large to tell.
    """
    nearest = min((float(round(rate)), *CAMERAS), key=lambda known: abs(known - rate))
    return nearest if nearest >= 1.0 and abs(nearest - rate) <= 3.0 * std and std < CLEAR else None


def _clocks(index: Array, low: Array, high: Array) -> tuple[float, float, float] | None:
    """Return the least and the largest period of the lines between `low` and `high`, and the start in their middle."""
    from scipy.optimize import linprog

    floor = _hull(zip(index.tolist(), low.tolist(), strict=True), 1.0)
    ceiling = _hull(zip(index.tolist(), high.tolist(), strict=True), -1.0)
    matrix = np.array([[-1.0, -i] for i, _ in floor] + [[1.0, i] for i, _ in ceiling])
    bound = np.array([-v for _, v in floor] + [v for _, v in ceiling])
    free = [(None, None), (None, None)]
    ends = []
    for sign in (1.0, -1.0):
        found = linprog([0.0, sign], A_ub=matrix, b_ub=bound, bounds=free)
        if found.status != 0 or found.x is None:
            return None
        ends.append(np.asarray(found.x, dtype=np.float64))
    middle = 0.5 * (ends[0] + ends[1])
    return float(ends[0][1]), float(ends[1][1]), float(middle[0])


def _hull(points: Iterable[tuple[float, float]], sign: float) -> list[tuple[float, float]]:
    """Return the upper (`sign` 1) or the lower hull (-1) of points in rising order (monotone chain, Andrew 1979)."""
    hull: list[tuple[float, float]] = []
    for x, y in points:
        while len(hull) > 1:
            (a, b), (c, d) = hull[-2:]
            if sign * ((c - a) * (y - b) - (d - b) * (x - a)) < 0.0:
                break
            hull.pop()
        hull.append((x, y))
    return hull
