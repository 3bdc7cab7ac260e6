"""A model as fitted to a session, and where it fails."""

from dataclasses import dataclass

from identify.comparison.compare import Comparison
from identify.fitting.baseline import Baseline


@dataclass(frozen=True, eq=False)
class Compared:
    """A model as fitted to the session `name`, and where it fails."""

    name: str
    baseline: Baseline
    comparison: Comparison
