"""A rejected release is taken again when asked for."""

from pathlib import Path

import pytest
from fault_bench import board, station_capture

from daq.session import Session

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
