"""A model as fitted to a session, and where it fails."""

from dataclasses import dataclass

from identify.compare import Comparison
from identify.search import Start
from identify.setting import Setting


@dataclass(frozen=True, eq=False)
class Compared:
    """A model as fitted to the session `name`, and where it fails."""

    name: str
    setting: Setting
    start: Start
    comparison: Comparison
