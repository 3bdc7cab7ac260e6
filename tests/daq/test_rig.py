"""A rig that releases itself is held, released and recorded; one that cannot, or that lets go, is said in one sentence."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench_double import double

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import BoardError, OperatorError
from daq.link import Link
from daq.port import open_port
from daq.rig import Rig
from daq.session import Session
from daq.session_info import State
from firmware_protocol import HolderReason, HolderState
from mocks.holding import SILENCE_S
from mocks.in_process import running

HOLDER = ("--holder", "-25,25", "--seed", "3")
SHORT = CaptureSettings(duration_s=3.0, release_from=0.012)


@contextmanager
def linked(*arguments: str) -> Iterator[Link]:
    with running("--tcp", "0", *arguments) as address, Link(open_port(address)) as link:
        link.handshake()
        yield link


def wait(link: Link, seconds: float) -> None:
    link.wait(lambda message: False, seconds)


def test_a_rig_is_captured_without_a_hand(tmp_path: Path) -> None:
    with double(tmp_path, "tcp", *HOLDER) as board:
        session = capture(board.port, SHORT, tmp_path / "s")
        (released,) = board.truth()["releases"]
    # How late a busy computer reads the samples, which the verdict tells as a doubt of their rate, is not the rig's.
    rig_s = [reason for reason in session.verdict.reasons if "the sampling rate is known to" not in reason]
    assert not rig_s
    recording = session.recording()
    assert recording.valid.all()
    assert released["from_m"] == pytest.approx(0.012, abs=1e-6)
    # The magnet takes 2 ms to let go: the motion shows some samples later.
    assert 0 <= recording.trigger - 256 <= 1
    assert "the rig let go from 12 mm" in recording.notes


def test_the_board_tells_at_which_sample_it_let_go(tmp_path: Path) -> None:
    with double(tmp_path, "tcp", *HOLDER) as board, Link(open_port(board.port)) as link:
        link.handshake()
        rig = Rig(link)
        link.start()
        rig.hold(0.012)
        first = rig.release()
        wait(link, 0.3)
        link.stop()
        (released,) = board.truth()["releases"]
    assert first is not None
    assert first - 1 < released["sample"] <= first


def test_what_was_recorded_begins_where_the_rig_held(tmp_path: Path) -> None:
    with double(tmp_path, "tcp", *HOLDER) as board:
        session = capture(board.port, CaptureSettings(duration_s=2.0, release_from=-0.02), tmp_path / "s")
        rest = capture(board.port, CaptureSettings(duration_s=1.0, wait_for_release=False), tmp_path / "r")
    held = session.recording().samples[0][50:250].mean()
    assert held - rest.recording().samples[0].mean() == pytest.approx(-0.02, abs=0.3e-3)


def test_a_board_without_a_holder_is_refused_before_a_session_begins(tmp_path: Path) -> None:
    with double(tmp_path, "tcp") as board, pytest.raises(OperatorError, match="has no holder") as raised:
        capture(board.port, SHORT, tmp_path / "s")
    assert raised.value.exit_code == 2
    assert not (tmp_path / "s").exists()


def test_a_displacement_beyond_the_limits_is_refused_before_anything_moves(tmp_path: Path) -> None:
    with double(tmp_path, "tcp", *HOLDER) as board, pytest.raises(OperatorError, match="-25 to 25 mm"):
        capture(board.port, CaptureSettings(release_from=0.03), tmp_path / "s")
    assert not (tmp_path / "s").exists()


def test_a_release_that_moves_nothing_is_said_so(tmp_path: Path) -> None:
    settings = CaptureSettings(release_from=0.001, trigger_level=0.01, trigger_timeout_s=1.0)
    with (
        double(tmp_path, "tcp", *HOLDER) as board,
        pytest.raises(OperatorError, match="the rig let go, and no swing came within 1 s"),
    ):
        capture(board.port, settings, tmp_path / "s")


def test_the_mass_stays_held_while_the_host_listens_and_is_let_go_when_it_does_not() -> None:
    with linked(*HOLDER) as link:
        rig = Rig(link)
        rig.hold(0.005)
        wait(link, SILENCE_S + 1.0)
        assert rig.report.state is HolderState.HELD
        link.keep_alive = False
        wait(link, SILENCE_S + 0.5)
        assert (rig.report.state, rig.report.reason) == (HolderState.LETTING_GO, HolderReason.SILENCE)
        with pytest.raises(BoardError, match="it did not hear from this computer; nothing was released"):
            rig.release()


def test_stop_lets_go_and_a_release_after_it_is_refused() -> None:
    with linked(*HOLDER) as link:
        rig = Rig(link)
        rig.hold(0.003)
        rig.stop()
        wait(link, 0.3)
        with pytest.raises(BoardError, match="it was told to stop"):
            rig.release()
        with pytest.raises(BoardError, match="the holder moves"):
            rig.hold(0.003)


def test_a_capture_that_is_interrupted_lets_go_slowly(tmp_path: Path) -> None:
    class Impatient(CaptureObserver):
        def state(self, name: str, detail: str) -> None:
            if name == "resting" and self.held:
                raise KeyboardInterrupt
            self.held = self.held or name == "holding"

        held = False

    with running("--tcp", "0", *HOLDER) as address:
        with pytest.raises(KeyboardInterrupt) as raised:
            capture(address, SHORT, tmp_path / "s", Impatient())
        assert raised.value.session == tmp_path / "s"
        with Link(open_port(address)) as link:
            link.handshake()
            report = Rig(link).report
    assert (report.state, report.reason) == (HolderState.LETTING_GO, HolderReason.STOP)


def test_a_rig_that_lets_go_before_the_release_ends_the_capture(tmp_path: Path) -> None:
    with (
        running("--tcp", "0", *HOLDER, "--fault", "stop-contact@1.5") as address,
        pytest.raises(BoardError, match="stop contact") as raised,
    ):
        capture(address, SHORT, tmp_path / "s")
    assert raised.value.exit_code == 4
    assert Session.open(tmp_path / "s").info.state is State.ABORTED


def test_a_board_that_boots_while_it_moves_the_mass_ends_the_capture(tmp_path: Path) -> None:
    with (
        running("--tcp", "0", *HOLDER, "--fault", "reboot@1.5") as address,
        pytest.raises(BoardError, match="its board restarted"),
    ):
        capture(address, SHORT, tmp_path / "s")
    assert Session.open(tmp_path / "s").info.state is State.ABORTED
