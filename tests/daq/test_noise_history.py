import os
from pathlib import Path

import numpy as np
import pytest
from scripted_board import RATE, decay

from daq.noise_history import typical_noise
from daq.quality import Grade, judge
from daq.recording import Channel, Recording
from daq.session_info import BoardInfo, SessionInfo

BOARD = BoardInfo(board="b", unique_id="77")
X = Channel("x", "displacement", "m", 1e-6, -0.05, 0.05)
A = Channel("a", "acceleration", "m/s^2", 1e-3, -50.0, 50.0)


def neighbours(folder: Path, noises: list[float], board: BoardInfo = BOARD) -> None:
    for number, noise in enumerate(noises):
        place = folder / f"{board.unique_id}_{number}"
        place.mkdir()
        info = SessionInfo(board=board, noise={"x": noise})
        (place / "session.json").write_text(info.model_dump_json())


def test_the_typical_noise_is_the_median_of_the_same_boards_sessions(tmp_path: Path) -> None:
    neighbours(tmp_path, [4e-6, 5e-6, 90e-6])
    neighbours(tmp_path, [1.0, 1.0, 1.0], BoardInfo(board="b", unique_id="78"))
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "session.json").write_text("{")
    assert typical_noise(tmp_path / "new", SessionInfo(board=BOARD)) == {"x": 5e-6}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_pipe_among_the_neighbours_is_not_waited_for(tmp_path: Path) -> None:
    neighbours(tmp_path, [4e-6, 5e-6, 6e-6])
    (tmp_path / "pipe").mkdir()
    os.mkfifo(tmp_path / "pipe" / "session.json")
    assert typical_noise(tmp_path / "new", SessionInfo(board=BOARD)) == {"x": 5e-6}


def test_two_sessions_are_too_few_to_say_what_is_typical(tmp_path: Path) -> None:
    neighbours(tmp_path, [4e-6, 5e-6])
    assert typical_noise(tmp_path / "new", SessionInfo(board=BOARD)) == {}


def recording(samples: np.ndarray) -> Recording:
    return Recording(RATE, (X, A), samples, np.ones(samples.shape[1], dtype=bool), trigger=256)


def test_noise_above_the_typical_is_reported_with_both_figures() -> None:
    good = recording(decay(2304, 256))
    verdict = judge(good, noise={"x": 2e-5}, typical={"x": 5e-6})
    assert verdict.grade is Grade.USABLE
    assert "x is 4.0 times as noisy at rest as usual (2e-05 m, usually 5e-06)" in verdict.reasons[0]
    assert judge(good, noise={"x": 1.4e-5}, typical={"x": 5e-6}).grade is Grade.OK


def test_a_trigger_by_a_touch_long_before_the_release_is_reported() -> None:
    late = recording(decay(2304, 1000))  # the trigger is at sample 256
    verdict = judge(late)
    assert verdict.grade is Grade.USABLE
    assert "triggered early, by a touch" in verdict.reasons[0]
