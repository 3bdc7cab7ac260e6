from pathlib import Path

import numpy as np
import pytest
from scripted_board import RATE, ScriptedBoard, decay

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import OperatorError
from daq.raw_log import Kind
from daq.recording import Channel, Gap, Recording
from daq.replay import replay
from daq.session import Session


class Witness(CaptureObserver):
    def __init__(self) -> None:
        self.seen: list[object] = []
        self.samples: list[np.ndarray] = []

    def connected(self, hello: object, channels: tuple[Channel, ...]) -> None:
        self.seen.append(tuple(channel.name for channel in channels))

    def state(self, name: str, detail: str) -> None:
        self.seen.append(name)

    def block(self, first_index: int, samples: np.ndarray) -> None:
        self.samples.append(samples)

    def loss(self, gap: Gap) -> None:
        self.seen.append(gap)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> tuple[Session, Witness]:
    board, live = ScriptedBoard(decay()), Witness()
    board.mangle = lambda first, frame: b"" if first == 1600 else frame
    settings = CaptureSettings(check_clock=False)
    return capture(board, settings, tmp_path_factory.mktemp("replay") / "s", live), live


@pytest.fixture
def pauses(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """The pauses that a replay makes, in s; none is waited for."""
    made: list[float] = []
    monkeypatch.setattr("daq.replay.time.sleep", made.append)
    return made


def test_a_replay_shows_what_was_seen_live(session: tuple[Session, Witness]) -> None:
    again = Witness()
    recording = replay(session[0], again, speed=0)
    live = session[1]
    assert len(again.samples) >= len(live.samples)
    assert all(np.array_equal(a, b) for a, b in zip(again.samples, live.samples, strict=False))
    assert [t for t in again.seen if isinstance(t, Gap)] == [t for t in live.seen if isinstance(t, Gap)]
    assert again.seen[0] == ("x", "a")
    assert again.seen[-1] == "sealed"
    assert np.array_equal(recording.samples, session[0].recording().samples)


def test_a_replay_keeps_the_time_it_took(session: tuple[Session, Witness], pauses: list[float]) -> None:
    times = [record.time for record in session[0].records() if record.kind is Kind.RECEIVED]
    replay(session[0], Witness(), speed=2.0)
    assert 0 < sum(pauses) <= (times[-1] - times[0]) / 2 + 1e-9


def test_an_import_is_replayed_by_the_time_of_its_samples(tmp_path: Path, pauses: list[float]) -> None:
    samples = decay(512)
    channels = (Channel("x", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    recording = Recording(RATE, channels, samples, np.ones(512, dtype=bool))
    session = Session.create_imported(tmp_path / "s", recording, None)
    witness = Witness()
    replay(session, witness, speed=8.0)
    # From the first sample to the first one of the last frame, which holds up to 61 of them.
    assert (512 - 61) / RATE / 8 <= sum(pauses) <= 512 / RATE / 8
    assert np.array_equal(np.concatenate(witness.samples, axis=1), samples)


@pytest.mark.parametrize("speed", [-1.0, float("nan"), float("inf")])
def test_a_speed_that_is_none_is_refused(session: tuple[Session, Witness], speed: float) -> None:
    with pytest.raises(OperatorError, match="speed"):
        replay(session[0], Witness(), speed)
