"""A model as fitted to a session, and where it fails."""

from dataclasses import dataclass

import numpy as np

from identify.comparison.compare import Comparison
from identify.fitting.baseline import Baseline


@dataclass(frozen=True, eq=False)
class Compared:
    """A model as fitted to the session `name`, and where it fails."""

    name: str
    baseline: Baseline
    comparison: Comparison

    @property
    def motion_floor(self) -> float:
        """What noise alone leaves of the motion, in % of its rms."""
        window, channel = self.baseline.fit.windows[0], self.comparison.motion_channel
        rms = float(np.std(window.readings[channel][window.used[channel]]))
        return 100.0 * self.comparison.floor[channel].std / rms if rms > 0 else float("nan")
