"""Not enough data: too few cycles to distinguish effects, or a motion that may be noise."""

import numpy as np

from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit
from identify.fitting.model_error import motion_percent
from identify.formatting import three_figures
from identify.priors import DROWNED, FEWEST_CYCLES


def too_few_cycles(baseline: Baseline) -> bool:
    """Check whether too few cycles of free motion, over all releases, stand above friction and noise."""
    seconds = sum(len(window) / window.rate for window in baseline.fit.windows)
    return seconds * baseline.fit.frequency / (2.0 * np.pi) < FEWEST_CYCLES


def is_drowned(baseline: Baseline, found: Fit) -> bool:
    """Check whether a fit leaves most of the motion and only a guessed floor accepts it: it would accept any model."""
    return not baseline.floor_is_sure and baseline.adequate(found) and motion_percent(found) > DROWNED


def why_not_enough(baseline: Baseline, found: Fit) -> str:
    """Explain why the data are not enough, and what to record."""
    if too_few_cycles(baseline):
        return (
            "Fewer than five cycles of free motion stand above friction and noise: too few to distinguish effects. "
            "Release from a larger amplitude, or record for longer."
        )
    return (
        f"The model leaves {three_figures(motion_percent(found))} % of the motion. The noise of this record is only a guess "
        "and may be as large, so any model would pass. Look at the record first: is this the right column, and is the "
        "mass swinging freely? If so, release from a larger amplitude, or record the sensor at rest before the release."
    )
