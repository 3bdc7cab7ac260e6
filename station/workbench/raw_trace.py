"""The trace of a record as it stands, for one that allows no analysis: what was recorded is shown all the same."""

import re
from pathlib import Path

import numpy as np

from daq.errors import StationError
from daq.session import Session
from station.settings import Settings
from station.story.pipeline import Progress
from station.text.numbers import scale_as_recorded, typeset
from station.workbench import view_models
from station.workbench.build_view_models import for_eye, numbers

PARTS = 700
MOST = 3


def raw_traces(settings: Settings, progress: Progress, folder: Path) -> tuple[view_models.RawTrace, ...]:
    """Return the first channels of a session, extremes kept; nothing where it cannot be read."""
    try:
        recording = Session.open(folder).recording()
    except StationError:
        return ()
    count = recording.samples.shape[1]
    if count < 2:
        return ()
    parts = np.array_split(np.arange(count), min(PARTS, count // 2))
    found = []
    for row, channel in enumerate(recording.channels[:MOST]):
        factor, unit = scale_as_recorded(channel.quantity, channel.unit)
        values = np.where(recording.valid, recording.samples[row], np.nan) * factor
        places = [place for part in parts for place in _extremes(values, part)]
        at = np.array(places, dtype=np.intp)
        found.append(
            view_models.RawTrace(
                _without_unit(channel.name),
                typeset(unit),
                numbers(at / recording.rate, 1e-4),
                for_eye(values[at]),
            )
        )
    return tuple(found)


def _without_unit(name: str) -> str:
    """Return the name of a channel without the unit that a file may have put behind it in brackets."""
    return re.sub(r"\s*[\[(][^\[\]()]*[\])]$", "", name) or name


def _extremes(values: np.ndarray, part: np.ndarray) -> list[int]:
    """Return the places of the smallest and the largest value of a part, in order; its first where nothing is known."""
    known = part[np.isfinite(values[part])]
    if len(known) == 0:
        return [int(part[0])]
    return sorted({int(known[np.argmin(values[known])]), int(known[np.argmax(values[known])])})
