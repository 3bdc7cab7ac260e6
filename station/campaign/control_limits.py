"""Control limits of an individuals chart: which values scatter more than the others do from one to the next."""

import numpy as np
from numpy.typing import NDArray

from station.results.campaign_document import Limits

MEDIAN_RANGE = 0.9539
"""Median of the range of two values from a normal distribution, in standard deviations: sqrt 2 * 0.6745."""

WIDTH = 3.0
FEWEST = 5


def control_limits(values: NDArray[np.float64]) -> tuple[Limits, NDArray[np.bool_]] | None:
    """Find the limits of values (n,) in the order in which they were made, and which are outside; None for fewer than five.

    Centre is the median, spread the median moving range / 0.954: the chart of individuals in its robust form
    (Montgomery, Statistical Quality Control, 6.4), of which a single outlier moves neither. A drift does not widen
    the limits: it leaves them. Where more than half of the values repeat, the spread is that of their absolute
    deviations, and 0 where these vanish too; nothing is outside then but what differs.
    """
    if len(values) < FEWEST:
        return None
    centre = float(np.median(values))
    spread = float(np.median(np.abs(np.diff(values)))) / MEDIAN_RANGE
    if spread == 0.0:
        spread = float(np.median(np.abs(values - centre))) / 0.6745
    slack = 1e-12 * max(abs(centre), float(np.max(np.abs(values))))
    off = WIDTH * spread
    limits = Limits(centre=centre, spread=spread, lower=centre - off, upper=centre + off)
    return limits, np.abs(values - centre) > off + slack
