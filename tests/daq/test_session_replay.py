import time
from pathlib import Path

import numpy as np
import pytest
from scripted_board import RATE, ScriptedBoard, decay

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import SettingsError
from daq.recording import Channel, Gap, Recording
from daq.replay import replay
from daq.session import Session


class Witness(CaptureObserver):
    def __init__(self) -> None:
        self.told: list[object] = []
        self.samples: list[np.ndarray] = []

    def connected(self, hello: object, channels: tuple[Channel, ...]) -> None:
        self.told.append(tuple(channel.name for channel in channels))

    def state(self, name: str, detail: str) -> None:
        self.told.append(name)

    def block(self, first_index: int, samples: np.ndarray) -> None:
        self.samples.append(samples)

    def loss(self, gap: Gap) -> None:
        self.told.append(gap)


@pytest.fixture
def session(tmp_path: Path) -> tuple[Session, Witness]:
    board, live = ScriptedBoard(decay()), Witness()
    board.mangle = lambda first, frame: b"" if first == 1600 else frame
    settings = CaptureSettings(check_clock=False)
    return capture(board, settings, tmp_path / "s", live), live


def test_a_replay_tells_what_was_told_live(session: tuple[Session, Witness]) -> None:
    again = Witness()
    recording = replay(session[0], again, speed=0)
    live = session[1]
    told = len(live.samples)
    assert len(again.samples) >= told
    assert all(np.array_equal(a, b) for a, b in zip(again.samples, live.samples, strict=False))
    assert [t for t in again.told if isinstance(t, Gap)] == [t for t in live.told if isinstance(t, Gap)]
    assert again.told[0] == ("x", "a")
    assert again.told[-1] == "sealed"
    assert np.array_equal(recording.samples, session[0].recording().samples)


def test_a_replay_keeps_the_time_it_took(session: tuple[Session, Witness]) -> None:
    """The board was hurried to 4096 samples a second: 0.73 s for 3000 samples, here twice as fast."""
    start = time.monotonic()
    replay(session[0], Witness(), speed=2.0)
    assert 0.2 < time.monotonic() - start < 2.0


def test_an_import_is_replayed_by_the_time_of_its_samples(tmp_path: Path) -> None:
    samples = decay(512)
    channels = (Channel("x", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    recording = Recording(RATE, channels, samples, np.ones(512, dtype=bool))
    session = Session.create_imported(tmp_path / "s", recording, None)
    witness = Witness()
    start = time.monotonic()
    replay(session, witness, speed=8.0)
    assert 0.15 < time.monotonic() - start < 1.5
    assert np.array_equal(np.concatenate(witness.samples, axis=1), samples)


@pytest.mark.parametrize("speed", [-1.0, float("nan"), float("inf")])
def test_a_speed_that_is_none_is_refused(session: tuple[Session, Witness], speed: float) -> None:
    with pytest.raises(SettingsError, match="speed"):
        replay(session[0], Witness(), speed)
