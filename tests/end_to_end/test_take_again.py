"""A rejected release is taken again when asked for; the noise of a session is held against its neighbours'."""

import json
from pathlib import Path

import pytest
from fault_bench import board, station_capture

from daq.session import Session
from daq.session_info import BoardInfo, SessionInfo, State

pytestmark = pytest.mark.usefixtures("unrendered")

FAST = ("--seed", "5", "--speed", "16")


def test_a_rejected_release_is_taken_again_twice_at_most_and_all_are_kept(tmp_path: Path) -> None:
    with board("tcp", *FAST, "--fault", "reversed") as port:
        outcome = station_capture(port, tmp_path / "s", "--duration", "2", "--again")
    assert outcome.said.count("taken again") == 2
    assert [Session.open(tmp_path / name).info.verdict for name in ("s", "s_2", "s_3")] == ["REJECT"] * 3


def test_without_a_terminal_nobody_is_asked(tmp_path: Path) -> None:
    with board("tcp", *FAST, "--fault", "reversed") as port:
        outcome = station_capture(port, tmp_path / "s", "--duration", "2")
    assert "again?" not in outcome.said
    assert not (tmp_path / "s_2").exists()


def neighbour(folder: Path, name: str, noise: float, unique_id: str = "SIM-0001") -> None:
    info = SessionInfo(
        state=State.SEALED, board=BoardInfo(unique_id=unique_id), rate_hz=256.0, noise={"acceleration": noise}
    )
    (folder / name).mkdir()
    (folder / name / "session.json").write_text(info.model_dump_json())


def test_a_board_that_is_noisier_than_usual_is_reported(tmp_path: Path) -> None:
    for number in range(3):
        neighbour(tmp_path, f"r{number}", 1e-3)
    with board("tcp", *FAST) as port:
        outcome = station_capture(port, tmp_path / "s", "--duration", "2")
    assert "times as noisy at rest as usual" in outcome.said
    manifest = json.loads((tmp_path / "s" / "manifest.json").read_text())
    assert manifest["verdict"]["word"] == "USABLE WITH GAPS"
    assert "acceleration is" in manifest["verdict"]["reasons"][0]
