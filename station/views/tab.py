"""A tab that brings its own data: how they are logged, and how the tab is laid out."""

from collections.abc import Callable
from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb


@dataclass(frozen=True)
class Tab:
    """One tab of the viewer."""

    name: str
    write: Callable[[rr.RecordingStream], None]
    layout: Callable[[], rrb.Container]
