"""The live view and the terminal while a board is recorded: every sample drawn, every state and loss told."""

import io
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader
from rich.console import Console

from daq.importing import read_file
from daq.importing.options import ImportOptions
from daq.recording import Gap
from daq.replay import replay
from daq.session import Session
from station.text.capture_progress import Watch
from station.views.live import LiveView

SAMPLE = Path(__file__).resolve().parent.parent / "data" / "release_12.csv"


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    folder = tmp_path_factory.mktemp("live") / "one"
    return Session.create_imported(folder, read_file(SAMPLE, ImportOptions()), SAMPLE)


def test_the_live_view_draws_every_sample_once_and_in_order(session, tmp_path):
    stream = rr.RecordingStream("live-test", send_properties=False)
    stream.save(tmp_path / "live.rrd")
    view = LiveView(stream, 256.0)
    replay(session, view, speed=0)
    stream.flush()
    stream.disconnect()
    recording = session.recording()
    name = recording.channels[0].name
    values = []
    for chunk in RrdReader(tmp_path / "live.rrd").stream().filter(content=f"/live/{name}"):
        batch = chunk.to_record_batch()
        if "Scalars:scalars" in batch.schema.names:
            values += [row[0] for row in batch.column("Scalars:scalars").to_pylist()]
    assert np.array_equal(values, recording.samples[0] * 1e3)


def test_the_terminal_tells_the_board_the_states_and_the_losses_without_a_terminal(session):
    out = io.StringIO()
    with Watch(console=Console(file=out, width=80)) as watch:
        replay(session, watch, speed=0)
        watch.loss(Gap(100, 16, "wire"))
    told = out.getvalue()
    assert "displacement" in told
    assert "recording the decay" in told
    assert "lost 16 samples from number 100 on: wire" in told


def test_the_terminal_shows_levels_in_a_terminal(session):
    out = io.StringIO()
    with Watch(console=Console(file=out, width=80, force_terminal=True)) as watch:
        replay(session, watch, speed=0)
    assert "mm" in out.getvalue()
