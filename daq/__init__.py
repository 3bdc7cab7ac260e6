"""A port in, a sealed session out: acquisition, sessions, replay and import.

In a notebook, `daq.read_recording("release.csv")` reads a file of another board: CSV as people have it, JSON,
MATLAB, UFF58; `daq.read_recordings` returns every run of a file that holds several.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from daq.importing import (
        ImportOptions,
        ImportProblem,
        read_file as read_recording,
        read_runs as read_recordings,
    )
    from daq.recording import Recording

__all__ = ["ImportOptions", "ImportProblem", "Recording", "read_recording", "read_recordings"]

_RENAMED = {"read_recording": "read_file", "read_recordings": "read_runs"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module 'daq' has no attribute '{name}'")
    home = import_module("daq.recording" if name == "Recording" else "daq.importing")
    return getattr(home, _RENAMED.get(name, name))
