"""A port in, a sealed session out: acquisition, sessions, replay and import.

In a notebook, `daq.read_recording("release.csv")` reads a file of another board: CSV as people have it, JSON,
MATLAB, UFF58; `daq.read_recordings` returns every run of a file that holds several.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from daq.importing.errors import ImportProblem
    from daq.importing.options import ImportOptions
    from daq.importing.reading import read_file as read_recording, read_runs as read_recordings
    from daq.recording import Recording

__all__ = ["ImportOptions", "ImportProblem", "Recording", "read_recording", "read_recordings"]

_HOMES = {
    "ImportOptions": ("daq.importing.options", "ImportOptions"),
    "ImportProblem": ("daq.importing.errors", "ImportProblem"),
    "Recording": ("daq.recording", "Recording"),
    "read_recording": ("daq.importing.reading", "read_file"),
    "read_recordings": ("daq.importing.reading", "read_runs"),
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'daq' has no attribute '{name}'")
    module, attribute = _HOMES[name]
    return getattr(import_module(module), attribute)
