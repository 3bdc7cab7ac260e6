"""Thumbnails: a session at a glance, for the list on the left."""

from functools import lru_cache
from pathlib import Path

import numpy as np

from daq.errors import StationError
from daq.recording import Array
from daq.session import Session
from station.text.numbers import scale_as_recorded, typeset
from station.workbench.view_models import Numbers, Thumbnail

POINTS = 60


@lru_cache(maxsize=1000)
def thumbnail_of(folder: Path, stamp: int) -> Thumbnail:
    """Find the largest amplitude and the outline of the decay; `problem` where the session cannot be read.

    `stamp` changes when the recording does: a thumbnail is made once for each.
    """
    try:
        recording = Session.open(folder).recording()
    except StationError as error:
        return Thumbnail("", [], str(error))
    if not recording.channels or recording.samples.shape[1] < 2:
        return Thumbnail("", [], "no samples")
    places = {channel.quantity: i for i, channel in reversed(list(enumerate(recording.channels)))}
    row = next((places[q] for q in ("displacement", "velocity", "acceleration") if q in places), 0)
    values = np.where(recording.valid, recording.samples[row], np.nan)
    if not np.isfinite(values).any():
        return Thumbnail("", [], "no samples")
    channel = recording.channels[row]
    factor, unit = scale_as_recorded(channel.quantity, channel.unit)
    largest, line = outline(values)
    return Thumbnail(f"{largest * factor:.3g} {typeset(unit)}", line)


def outline(values: Array) -> tuple[float, Numbers]:
    """Measure how far values go from their median, and their upper and lower outline as shares of that; NaN leave holes."""
    if not np.isfinite(values).any():
        return 0.0, []
    values = values - np.nanmedian(values)
    largest = float(np.nanmax(np.abs(values)))
    line: list[float | None] = []
    for part in np.array_split(values, POINTS):
        finite = part[np.isfinite(part)]
        if len(finite):
            line += [round(float(edge) / (largest or 1.0), 2) for edge in (finite.max(), finite.min())]
        else:
            line += [None, None]
    return largest, line
