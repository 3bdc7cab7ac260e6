"""A disk that fails under `station capture`: the session goes to the spare place and nothing is lost."""

import shutil
from pathlib import Path
from unittest import mock

import pytest
from fault_bench import board, station_capture

from daq.capture_stream import CaptureStream
from daq.session import Session, verify


@pytest.mark.usefixtures("unrendered")
def test_a_folder_deleted_in_mid_capture_moves_the_session_to_the_spare_place(tmp_path: Path) -> None:
    state = CaptureStream.state

    def delete(stream: CaptureStream, step: str, detail: str) -> None:
        if step == "triggered":
            shutil.rmtree(tmp_path / "s")
        state(stream, step, detail)

    options = ("--duration", "4", "--spare", str(tmp_path / "spare"))
    with (
        board("tcp", "--seed", "5", "--speed", "16") as port,
        mock.patch.object(CaptureStream, "state", delete),
    ):
        outcome = station_capture(port, tmp_path / "s", *options)
    assert outcome.code == 0, outcome.said
    (folder,) = (tmp_path / "spare").iterdir()
    session = Session.open(folder)
    assert session.recording().valid.all()
    assert session.recording().samples.shape[1] == 5 * 256  # 1 s before the release and 4 s after it
    assert verify(folder).ok
