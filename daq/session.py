"""A session: a folder with the raw bytes (the truth), what they mean (metadata) and what was made of them.

session.json    metadata, and the state: recording, sealed, recovered, aborted
raw.log         every byte as it came, see `raw_log`
source/         for an import, a copy of the file
recipe.toml     for an import, how the file was read
results/        derived, can be made again
manifest.json   checksums, counts, gaps, verdict
.lock           while a process writes the session
.NAME.MARK.new  the content of NAME that waits until the manifest names it, see `session_changes`
"""

from daq.manifest import Verification, verify
from daq.session_folder import Session
from daq.session_info import BoardInfo, SensorInfo, SessionInfo, State
from daq.session_recovery import (
    SessionSummary,
    finish_change,
    list_sessions,
    recover,
    unsealed_sessions,
)

__all__ = [
    "BoardInfo",
    "SensorInfo",
    "Session",
    "SessionInfo",
    "SessionSummary",
    "State",
    "Verification",
    "finish_change",
    "list_sessions",
    "recover",
    "unsealed_sessions",
    "verify",
]
