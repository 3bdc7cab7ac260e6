"""The key of a session's result: a checksum of all that the result depends on."""

import hashlib
import json
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from daq.session_info import SessionInfo
from station.story.preparation import Options

DISTRIBUTION = "free-decay-station"


def key_of(raw: bytes, info: SessionInfo, options: Options, **settings: Any) -> str:
    """Return the key of a session: its readings, its calibrations, the options, other settings and the program.

    What else its metadata say may change without another result: it is read afresh for every table.
    """
    try:
        program = version(DISTRIBUTION)
    except PackageNotFoundError:  # it runs without being installed
        program = ""
    dependent = {
        "sensors": [sensor.model_dump(mode="json") for sensor in info.sensors],
        "rate_std_hz": info.rate_std_hz,
        "options": asdict(options),
        "settings": settings,
        "program": program,
    }
    checksum = hashlib.sha256(json.dumps(dependent, sort_keys=True).encode())
    checksum.update(hashlib.sha256(raw).digest())
    return checksum.hexdigest()
