"""What a series of values shows: control limits of an individuals chart, and a straight line with its significance."""

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from identify.arrays import Array
from station.results.campaign_document import Trend

MEDIAN_RANGE = 0.9539
"""Median of the range of two values from a normal distribution, in standard deviations: sqrt 2 * 0.6745."""

WIDTH = 3.0
FEWEST, FEWEST_PLACES = 5, 3

FAR = 5.0
"""Standard deviations off the robust line from which on a value is left out: it is an outlier, not the trend."""

MOST_PAIRED = 800

ROUNDING = 1e-12
"""Share of values below which a difference is rounding."""


def control_limits(values: Array) -> tuple[float, float, NDArray[np.bool_]] | None:
    """Find centre and spread of values (n,) in the order in which they were made, and which are outside three spreads.

    None for fewer than five. Centre is the median, spread the median moving range / 0.954: the chart of individuals in its
    robust form (Montgomery, Statistical Quality Control, 6.4), of which a single outlier moves neither. A drift does not
    widen the limits: it leaves them. Where more than half of the values repeat, the spread is that of their absolute
    deviations, and 0 where these vanish too; nothing is outside then but what differs.
    """
    if len(values) < FEWEST:
        return None
    centre = float(np.median(values))
    spread = float(np.median(np.abs(np.diff(values)))) / MEDIAN_RANGE
    if spread == 0.0:
        spread = float(np.median(np.abs(values - centre))) / 0.6745
    slack = ROUNDING * max(abs(centre), float(np.max(np.abs(values))))
    return centre, spread, np.abs(values - centre) > WIDTH * spread + slack


def find_trend(x: Array, y: Array, std: Array) -> Trend | None:
    """Return the trend of y (n,) with standard errors (n,) against x (n,); None where there is too little of either.

    Weighted least squares with weights 1/(std^2 + tau^2); tau is the scatter from session to session that the
    stated errors do not explain, such that the weighted squares left are what n - 2 degrees of freedom expect (Paule
    and Mandel 1982, for a regression: DerSimonian and Kacker 2007). Without errors (not finite) all weigh the same.
    Student's t with n - 2 degrees of freedom gives the p-value. Values more than five standard deviations off the line
    of Theil and Sen are left out.
    """
    kept = np.isfinite(x) & np.isfinite(y)
    x, y, std = x[kept], y[kept], std[kept]
    if len(x) < FEWEST or len(np.unique(x)) < FEWEST_PLACES or np.ptp(y) == 0.0:
        return None
    known = np.isfinite(std) & (std > 0.0)
    own = np.where(known, std, np.median(std[known])) if known.any() else np.zeros(len(x))
    near = _near(x, y, own)
    left_out = int((~near).sum())
    x, y, own = x[near], y[near], own[near]
    if len(x) < FEWEST or len(np.unique(x)) < FEWEST_PLACES or np.ptp(y) == 0.0:
        return None
    tau = _scatter(x, y, own)
    if not own.any() and tau <= ROUNDING * np.max(
        np.abs(y)
    ):  # all lie on the line, which says nothing of its error
        return None
    slope, error = _line(x, y, 1.0 / (own**2 + tau**2))[:2]
    p_value = float(2.0 * stats.t.sf(abs(slope) / error, len(x) - 2))
    return Trend(slope=slope, std=error, p_value=p_value, sessions=len(x), left_out=left_out)


def _near(x: Array, y: Array, own: Array) -> NDArray[np.bool_]:
    """Find the values that lie near a robust line, within their errors and the usual scatter."""
    some = slice(None, None, -(-len(x) // MOST_PAIRED))
    slope = stats.theilslopes(y[some], x[some]).slope if np.ptp(x[some]) > 0.0 else 0.0
    rest = y - slope * x
    rest = rest - np.median(rest)
    scatter = float(np.median(np.abs(rest))) / 0.6745
    allowed = FAR * np.sqrt(own**2 + scatter**2)
    return np.asarray((np.abs(rest) <= allowed) | (allowed == 0.0))


def sure_ones(p_values: list[float]) -> list[bool]:
    """Find which of several hypotheses are rejected together at the level of 5 %, by Holm's step-down (1979)."""
    order = np.argsort(p_values)
    sure = [False] * len(p_values)
    for rank, i in enumerate(order):
        if p_values[i] > 0.05 / (len(p_values) - rank):
            break
        sure[i] = True
    return sure


def _line(x: Array, y: Array, weight: Array) -> tuple[float, float, float]:
    """Return slope, standard error and weighted sum of squares of a line."""
    centred = x - np.average(x, weights=weight)
    line, covariance = np.polyfit(centred, y, 1, w=np.sqrt(weight), cov="unscaled")
    rest = y - np.polyval(line, centred)
    return float(line[0]), float(np.sqrt(covariance[0, 0])), float(weight @ rest**2)


def _scatter(x: Array, y: Array, own: Array) -> float:
    degrees = len(x) - 2
    if not own.any():
        return float(np.sqrt(_line(x, y, np.ones(len(x)))[2] / degrees))

    def excess(tau: float) -> float:
        return _line(x, y, 1.0 / (own**2 + tau**2))[2] - degrees

    largest = float(np.ptp(y))
    if excess(0.0) <= 0.0:
        return 0.0
    return float(optimize.brentq(excess, 0.0, 2.0 * largest, xtol=1e-6 * largest))
