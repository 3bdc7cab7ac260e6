import shutil
from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest
from scripted_board import RATE, RELEASE, ScriptedBoard, decay

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import (
    BoardError,
    DataLost,
    LinkLost,
    OperatorError,
    PortError,
    StorageError,
)
from daq.link import Link
from daq.recording import Channel, Gap
from daq.session import Session, SessionInfo, State, recover, verify
from firmware_protocol import Clock, Config, Describe, Hello, Nack, NackCode, Start, Stop

SETTINGS = CaptureSettings(duration_s=8.0, check_clock=False, info=SessionInfo(operator="Ada", mass_kg=21.36))
SAMPLES = decay()


class Witness(CaptureObserver):
    """Remembers every call."""

    def __init__(self) -> None:
        self.states: list[str] = []
        self.details: list[str] = []
        self.samples: dict[int, np.ndarray] = {}
        self.losses: list[Gap] = []
        self.channels: tuple[Channel, ...] = ()
        self.on_state = lambda name: None

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        self.channels = channels

    def state(self, name: str, detail: str) -> None:
        self.states.append(name)
        self.details.append(detail)
        self.on_state(name)

    def block(self, first_index: int, samples: np.ndarray) -> None:
        self.samples[first_index] = samples

    def loss(self, gap: Gap) -> None:
        self.losses.append(gap)


def test_a_capture_goes_from_rest_to_a_sealed_session(tmp_path: Path) -> None:
    board, witness = ScriptedBoard(SAMPLES), Witness()
    session = capture(board, SETTINGS, tmp_path / "s", witness)
    assert witness.states == ["resting", "armed", "triggered", "recording", "sealed"]
    assert [channel.name for channel in witness.channels] == ["x", "a"]
    assert board.closed
    recording = session.recording()
    assert recording.trigger == 256
    assert recording.samples.shape == (2, 9 * 256)
    assert recording.valid.all()
    first = RELEASE + 1 - 256
    assert np.array_equal(recording.samples, SAMPLES[:, first : first + 9 * 256])
    live = np.concatenate([witness.samples[i] for i in sorted(witness.samples)], axis=1)
    assert np.array_equal(live[:, first : first + 9 * 256], recording.samples)


def test_the_session_says_who_and_what(tmp_path: Path) -> None:
    info = capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s").info
    assert (info.state, info.verdict, info.operator) == (State.SEALED, "OK", "Ada")
    assert info.source == "scripted"
    assert info.board is not None
    assert info.board.board == "scripted"
    # the standard error of a standard deviation from 256 samples is 4.4 %; four of them
    assert info.noise == pytest.approx({"x": 5e-6, "a": 0.01}, rel=0.18)
    assert verify(tmp_path / "s").ok


def test_lost_frames_are_asked_for_again(tmp_path: Path) -> None:
    board, witness = ScriptedBoard(SAMPLES), Witness()
    lost = {800, 816, 1600, 2400}
    board.mangle = lambda first, frame: b"" if first in lost else frame
    session = capture(board, SETTINGS, tmp_path / "s", witness)
    assert sum(gap.count for gap in witness.losses) == 64
    assert "resending" in witness.states
    recording = session.recording()
    assert recording.valid.all()
    assert np.array_equal(recording.samples, SAMPLES[:, 445 : 445 + 9 * 256])
    assert session.manifest().counts.resent == 64


def test_what_stays_lost_is_a_gap_and_never_a_number(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.held = 256
    board.mangle = lambda first, frame: b"" if first == 1600 else frame
    session = capture(board, SETTINGS, tmp_path / "s")
    recording = session.recording()
    assert recording.gaps == (Gap(1600 - 445, 16, "wire"),)
    assert np.isnan(recording.samples[:, ~recording.valid]).all()
    assert session.info.verdict == "USABLE WITH GAPS"
    assert session.manifest().gaps[0].reason == "wire"


def test_an_overrun_of_the_board_is_not_asked_for_again(tmp_path: Path) -> None:
    board, witness = ScriptedBoard(SAMPLES), Witness()
    board.dropped = {1600}
    session = capture(board, SETTINGS, tmp_path / "s", witness)
    assert "resending" not in witness.states
    assert session.recording().gaps == (Gap(1600 - 445, 16, "overrun"),)


def test_more_loss_than_the_limit_is_an_error_and_the_session_is_kept(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.dropped = set(range(1600, 1760, 16))
    with pytest.raises(DataLost, match="160 of 2304 samples stayed lost") as caught:
        capture(board, SETTINGS, tmp_path / "s")
    assert caught.value.session == tmp_path / "s"
    assert Session.open(tmp_path / "s").info.verdict == "REJECT"


def test_a_damaged_frame_costs_that_frame_only(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.mangle = lambda first, frame: bytes((frame[0] ^ 64, *frame[1:])) if first == 1200 else frame
    session = capture(board, SETTINGS, tmp_path / "s")
    assert session.recording().valid.all()
    assert session.manifest().counts.damaged_frames == 1


def test_a_silent_board_is_announced_and_then_given_up(tmp_path: Path) -> None:
    board, witness = ScriptedBoard(SAMPLES), Witness()
    board.silent_from = 1600
    with pytest.raises(LinkLost, match="silent for 2 s; what was received is kept"):
        capture(board, SETTINGS, tmp_path / "s", witness)
    assert witness.details[-1] == "nothing came for 0.5 s"
    session = Session.open(tmp_path / "s")
    assert session.info.state is State.ABORTED
    assert np.array_equal(session.recording().samples, SAMPLES[:, 445:1600])
    assert session.verdict is not None
    assert "early" in session.verdict.reasons[0]


def test_an_unplugged_board_leaves_what_was_received(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.unplugged_at = 1600
    with pytest.raises(LinkLost) as caught:
        capture(board, SETTINGS, tmp_path / "s")
    assert caught.value.exit_code == 6
    assert np.array_equal(Session.open(tmp_path / "s").recording().samples, SAMPLES[:, 445:1600])


def test_a_reboot_is_seen_though_the_board_does_not_greet(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.reboots_at = 1600
    with pytest.raises(LinkLost, match="rebooted in mid-capture"):
        capture(board, SETTINGS, tmp_path / "s")
    recording = Session.open(tmp_path / "s").recording()
    assert recording.gaps == (Gap(1600 - 445, 445 + 2304 - 1600, "reboot"),)


def test_a_trigger_that_never_comes_ends_with_a_clear_message(tmp_path: Path) -> None:
    still = decay(release=1e9)
    settings = CaptureSettings(trigger_timeout_s=5.0, check_clock=False)
    with pytest.raises(OperatorError, match="no release within 5 s"):
        capture(ScriptedBoard(still), settings, tmp_path / "s")
    assert Session.open(tmp_path / "s").info.state is State.ABORTED


def test_a_mass_that_never_rests_ends_with_a_clear_message(tmp_path: Path) -> None:
    t = np.arange(9000) / RATE
    sway = np.array([0.02 * np.sin(t) + 0.004 * t, -0.02 * np.sin(t)])
    settings = CaptureSettings(rest_timeout_s=3.0, check_clock=False)
    with pytest.raises(OperatorError, match="did not come to rest"):
        capture(ScriptedBoard(sway), settings, tmp_path / "s")


@pytest.mark.parametrize("release", [80, 140, 200])
def test_a_release_before_the_rest_is_complete_is_not_missed(tmp_path: Path, release: int) -> None:
    session = capture(ScriptedBoard(decay(release=release)), SETTINGS, tmp_path / "s")
    window = session.assembly().window
    assert window is not None
    assert window.trigger is not None
    assert window.first == 0
    assert abs(window.trigger - release) <= 1


def test_without_a_trigger_it_records_from_the_rest_on(tmp_path: Path) -> None:
    settings = CaptureSettings(duration_s=2.0, wait_for_release=False, check_clock=False)
    recording = capture(ScriptedBoard(decay(release=1e9)), settings, tmp_path / "s").recording()
    assert recording.trigger is None
    assert recording.samples.shape == (2, 3 * 256)


@pytest.mark.parametrize("request_type", [Config, Start, Stop])
def test_a_request_that_gets_lost_is_sent_again(tmp_path: Path, request_type: type) -> None:
    board = ScriptedBoard(SAMPLES)
    board.ignore = [request_type]
    assert capture(board, SETTINGS, tmp_path / "s").info.verdict == "OK"


def test_a_refusal_is_reported_in_the_words_of_the_board(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.refuse = {Config: Nack(0, 0, NackCode.UNSUPPORTED, "100 or 200 Hz only")}
    with pytest.raises(BoardError, match="cannot do 256 Hz: 100 or 200 Hz only"):
        capture(board, SETTINGS, tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_a_port_at_which_nothing_answers_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Mute(ScriptedBoard):
        def write(self, data: bytes) -> None:
            pass

    monkeypatch.setattr(Link, "handshake", partialmethod(Link.handshake, 0.5))
    with pytest.raises(PortError, match=r"nothing answered within 0.5 s"):
        capture(Mute(SAMPLES), SETTINGS, tmp_path / "s")


def test_a_board_that_contradicts_itself_is_stopped(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.description = type(board.description)(board.description.format, board.description.channels[:1])
    with pytest.raises(BoardError, match="samples of 2 channels, but 1 were described"):
        capture(board, SETTINGS, tmp_path / "s")


def test_an_existing_session_is_not_overwritten(tmp_path: Path) -> None:
    capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s")
    before = (tmp_path / "s" / "raw.log").read_bytes()
    with pytest.raises(OperatorError, match="nothing was overwritten"):
        capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s")
    assert (tmp_path / "s" / "raw.log").read_bytes() == before


def test_ctrl_c_leaves_a_session_that_can_be_recovered(tmp_path: Path) -> None:
    class Impatient(Witness):
        def block(self, first_index: int, samples: np.ndarray) -> None:
            if first_index >= 1600:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s", Impatient())
    assert Session.open(tmp_path / "s").info.reason == "interrupted"
    recording = recover(tmp_path / "s").recording()
    assert recording.samples.shape[1] >= 1600 - 445
    assert np.array_equal(recording.samples, SAMPLES[:, 445 : 445 + recording.samples.shape[1]])


def test_a_folder_that_vanishes_costs_nothing(tmp_path: Path) -> None:
    witness = Witness()
    witness.on_state = lambda name: shutil.rmtree(tmp_path / "s") if name == "triggered" else None
    asked: list[StorageError] = []

    def fallback(error: StorageError) -> Path:
        asked.append(error)
        return tmp_path / "t"

    session = capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s", witness, fallback)
    assert session.folder == tmp_path / "t"
    assert "its folder vanished" in str(asked[0])
    assert str(asked[0]).endswith("; the recording is held in memory")
    assert np.array_equal(session.recording().samples, SAMPLES[:, 445 : 445 + 9 * 256])
    assert verify(tmp_path / "t").ok


def test_without_another_place_the_loss_is_said(tmp_path: Path) -> None:
    witness = Witness()
    witness.on_state = lambda name: shutil.rmtree(tmp_path / "s") if name == "triggered" else None
    with pytest.raises(StorageError, match="no place was found"):
        capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "s", witness, lambda error: None)


def test_a_disk_that_refuses_at_once_is_reported_before_the_mass_is_released(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    witness = Witness()
    with pytest.raises(StorageError):
        capture(ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "file" / "s", witness)
    assert witness.states == []
    session = capture(
        ScriptedBoard(SAMPLES), SETTINGS, tmp_path / "file" / "s", witness, lambda error: tmp_path / "t"
    )
    assert session.folder == tmp_path / "t"


def clocked(board: ScriptedBoard, rate: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this computer's clock run as if the board sampled at `rate` Hz, and frames come one by one."""
    board.at_most = 16
    monkeypatch.setattr("daq.raw_log.host_time", lambda: 1e9 + board.sent / rate)


def test_the_rate_is_compared_with_this_computers_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = ScriptedBoard(SAMPLES)
    clocked(board, 1.002 * RATE, monkeypatch)
    session = capture(board, CaptureSettings(), tmp_path / "s")
    assert session.info.verdict == "OK"
    assert session.recording().rate_std == pytest.approx(0.002 * RATE, rel=1e-3)


class StatedClock(ScriptedBoard):
    """States the error of its clock behind each DESCRIBE."""

    def _send(self, message: object) -> None:
        super()._send(message)
        if isinstance(message, Describe):
            super()._send(Clock(30.0))


@pytest.mark.parametrize(("faster", "std_ppm"), [(1e-6, 30.0), (2e-3, 2000.0)])
def test_a_stated_clock_error_is_believed_as_far_as_this_computers_clock_bears_it_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, faster: float, std_ppm: float
) -> None:
    board = StatedClock(SAMPLES)
    clocked(board, (1 + faster) * RATE, monkeypatch)
    session = capture(board, CaptureSettings(), tmp_path / "s")
    found = session.recording().rate_std
    assert found is not None
    # 30 ppm stated; frames of 16 samples that come at once leave less than that
    assert found <= 1.001e-6 * std_ppm * RATE
    assert faster < 1e-3 or found == pytest.approx(1e-6 * std_ppm * RATE, rel=1e-3)


def test_a_rate_that_this_computers_clock_contradicts_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    board = ScriptedBoard(SAMPLES)
    clocked(board, 1.1 * RATE, monkeypatch)
    session = capture(board, CaptureSettings(), tmp_path / "s")
    assert session.recording().rate_std == pytest.approx(0.1 * RATE, rel=1e-3)
    assert session.verdict is not None
    assert "of this computer's clock" in session.verdict.reasons[0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"duration_s": 0.0},
        {"duration_s": float("nan")},
        {"rate_hz": -1.0},
        {"pre_trigger_s": 0.1},
        {"lost_limit": 2.0},
        {"trigger_level": 0.0},
    ],
)
def test_settings_out_of_range_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(OperatorError, match="must be"):
        CaptureSettings(**wrong)  # type: ignore[arg-type]
