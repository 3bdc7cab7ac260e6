"""How long a campaign takes beside the sum of its parts: hundreds of simulated sessions on the cores here."""

import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from daq.recording import Channel, Recording
from daq.session import Session
from mocks.generate import draw

TITLE = "A campaign"

ROOT = Path(__file__).resolve().parent.parent
SESSIONS, QUICK = 500, 60
ALONE = 40
CHANNELS = (Channel("displacement", "displacement", "m"), Channel("acceleration", "acceleration", "m/s^2"))


def run(quick: bool = False, sessions: int | None = None) -> str:
    count = sessions or (QUICK if quick else SESSIONS)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "sessions"
        _make(folder, count)
        alone = _alone(folder, min(ALONE, count))
        wall = _campaign(folder)
        found = json.loads((folder / "campaign" / "campaign.json").read_text())
        again = _campaign(folder)
    workers = found["workers"]
    assert len(found["rows"]) == count, found["failed"]
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    busy = os.getloadavg()[0]
    return (
        f"{count} simulated sessions (8 s at 256 Hz, two channels), {workers} workers: {wall:.0f} s, at a load of {busy:.1f} in the end. "
        f"One session takes {alone:.2f} s alone. A second run with nothing to do: {again:.1f} s. Largest process: {memory:.0f} MB."
    )


def _make(folder: Path, count: int) -> None:
    for i in range(count):
        sample = draw(None, 0.0, i)
        readings = np.array([sample.displacement, sample.acceleration])
        recording = Recording(sample.rate, CHANNELS, readings, np.ones(readings.shape[1], dtype=bool))
        Session.create_imported(folder / f"release_{i:04d}", recording, None)


def _alone(folder: Path, count: int) -> float:
    """Return seconds of one session in this process, where everything is compiled already."""
    from station.campaign.sources import find_sources
    from station.campaign.work import perform, work_on
    from station.settings import Settings

    sources = find_sources((str(folder),), Settings())[:count]
    works = [work_on(source.folder, Settings(), False) for source in sources]
    perform(works[0])
    took = []
    for work in works:
        before = time.perf_counter()
        perform(work)
        took.append(time.perf_counter() - before)
    return statistics.median(took)


def _campaign(folder: Path) -> float:
    before = time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "station", "campaign", str(folder), "--json"],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"},
    )
    return time.perf_counter() - before
