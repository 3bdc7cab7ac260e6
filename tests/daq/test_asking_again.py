"""What a capture asks for again, what it takes at most, and what it refuses, on a scripted board."""

import time
from pathlib import Path

import pytest
from lying_conversation import longest_s
from scripted_board import ScriptedBoard, decay

from daq.capture import CaptureSettings, capture
from daq.decode import MAX_MISSING
from daq.errors import BoardError, DataLost, LinkLost, OperatorError, PortError
from daq.importing import errors
from daq.link import MOST_BYTES, Link
from daq.raw_log import MAX_LOG
from firmware_protocol import Data, Hello, HelloRequest, Resend, SampleFormat, Start, Stop, encode

SAMPLES = decay()
SETTINGS = CaptureSettings(duration_s=4.0, check_clock=False)


def lossy(*firsts: int, held: int = 10**9) -> ScriptedBoard:
    board = ScriptedBoard(SAMPLES)
    board.mangle = lambda first, frame: b"" if first in firsts else frame
    board.held = held
    return board


def test_a_frame_lost_before_the_recording_is_asked_for_since_the_checksum_needs_it(tmp_path: Path) -> None:
    session = capture(lossy(16, 1600), SETTINGS, tmp_path / "s")
    assert session.info.verdict == "OK"
    assert session.manifest().counts.resent == 32


def test_what_the_board_no_longer_holds_leaves_the_recording_usable(tmp_path: Path) -> None:
    session = capture(lossy(16, 1600, held=1500), SETTINGS, tmp_path / "s")
    assert session.recording().gaps == ()
    verdict = session.verdict
    assert verdict is not None
    assert (verdict.grade.value, len(verdict.reasons)) == ("USABLE WITH GAPS", 1)
    assert "16 samples that it covers are lost, 16 from before the recording" in verdict.reasons[0]


class Endless(ScriptedBoard):
    """Answers every RESEND with the first frame of the capture, for ever."""

    def _resend(self, sequence: int, request: Resend) -> None:
        self.asked = getattr(self, "asked", 0) + 1

    def read(self) -> bytes:
        again = encode(self._data(0, 16), 77) * 20 if getattr(self, "asked", 0) else b""
        return super().read() + again


@pytest.mark.slow
def test_a_reply_that_never_ends_is_given_up(tmp_path: Path) -> None:
    board = Endless(SAMPLES)
    board.mangle = lambda first, frame: b"" if first % 320 == 0 else frame
    with pytest.raises(DataLost):
        capture(board, SETTINGS, tmp_path / "s")
    assert board.asked == 4  # the first of these was answered as asked


class Babbling:
    """A port that only makes noise."""

    name = "babbling"

    def __init__(self, noise: bytes = bytes(range(1, 255)) * 2000) -> None:
        self._noise = noise
        self.taken = 0

    def read(self) -> bytes:
        self.taken += len(self._noise)
        return self._noise

    def write(self, data: bytes) -> None:
        pass

    def close(self) -> None:
        pass


def test_noise_is_read_up_to_a_limit() -> None:
    board = Babbling()
    with Link(board) as link, pytest.raises(BoardError, match=r"more than 4 MB came.*check baud rate"):
        link.handshake()
    assert board.taken < 6e6


class Answering(Babbling):
    """A port that sends the same bytes again and again, slowly."""

    def __init__(self, *frames: bytes) -> None:
        super().__init__(b"".join(frames))

    def read(self) -> bytes:
        time.sleep(0.01)
        return super().read()


def malformed() -> bytes:
    """A DATA that promises more samples than it holds, in a sound frame."""
    whole = Data(0, 0, 0, 4, 1, SampleFormat.I16, bytes(8))
    frame = encode(whole, 0)
    from zlib import crc32

    from cobs import cobs

    plain = cobs.decode(frame[:-1])[:-4][:-2]
    return cobs.encode(plain + crc32(plain).to_bytes(4, "little")) + b"\0"


@pytest.mark.parametrize(
    ("frames", "error", "words"),
    [
        ((malformed(),), BoardError, r"sound but not understood \(type 0x85: DATA holds fewer samples"),
        ((encode(Hello(1, 1), 0),), BoardError, "says HELLO and does not describe its channels"),
        (
            (encode(HelloRequest(), 0),),
            BoardError,
            "frames came whole within 0.1 s, and none was the HELLO",
        ),
        ((b"Temperature: 21.5\r\n",), PortError, "no answer of a board; check baud rate"),
    ],
)
def test_what_is_sound_and_not_understood_is_not_put_down_to_the_line(
    frames: tuple[bytes, ...], error: type[Exception], words: str
) -> None:
    with Link(Answering(*frames)) as link, pytest.raises(error, match=words):
        link.handshake(0.1)


def test_a_capture_that_no_session_could_hold_is_refused_before_start(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    settings = CaptureSettings(duration_s=3600, trigger_timeout_s=3600)
    assert settings.log_bytes(256.0, 16) < 1 << 29
    with pytest.raises(OperatorError, match=r"at 50000 Hz this capture may take 6.25 GB .*lower rate"):
        settings.log_bytes(50_000.0, 16)
    board.description = type(board.description)(
        board.description.format,
        tuple(type(c)(c.name, c.quantity, c.unit, 1.0, 0.0, 50_000.0) for c in board.description.channels),
    )
    with pytest.raises(OperatorError):
        capture(board, settings, tmp_path / "s")
    assert board.sent == 0
    assert not (tmp_path / "s").exists()


def test_two_channels_of_one_name_have_each_its_own_noise(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    named = tuple(type(c)(**{**vars(c), "name": "x"}) for c in board.description.channels)
    board.description = type(board.description)(board.description.format, named)
    session = capture(board, SETTINGS, tmp_path / "s")
    assert session.info.verdict == "OK"
    assert list(session.info.noise) == ["x", "x 2"]


def test_an_answer_lost_in_noise_is_put_down_to_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("daq.link.ANSWER_S", (0.6,))
    board = ScriptedBoard(SAMPLES)

    def noise() -> bytes:
        time.sleep(0.01)
        return b"\0garble\0" * 30

    with Link(board) as link:
        link.handshake()
        board.read = noise  # type: ignore[method-assign]
        time.sleep(0.05)  # what the reader had begun to read is over
        with pytest.raises(LinkLost, match="no answer to STOP came through the noise"):
            link.request(Stop())


def test_the_limits_on_the_page_are_those_of_the_program() -> None:
    page = (Path(__file__).parents[2] / "docs" / "faults.md").read_text(encoding="utf-8")
    besides = (
        longest_s(SETTINGS) - SETTINGS.rest_timeout_s - SETTINGS.trigger_timeout_s - 2 * SETTINGS.duration_s
    )
    assert f"and {besides:g} s besides" in " ".join(page.split())
    assert f"| {MOST_BYTES / 1e6:.0f} MB |" in page
    assert f"| {MAX_LOG / 1e9:.1f} GB (2^31 bytes) |" in page
    assert f"| {MAX_MISSING / 1e6:.0f} million numbers ({8e-6 * MAX_MISSING:.0f} MB) |" in page
    assert (
        f"| {errors.MAX_BYTES / 1e6:.0f} MB, unpacked too; {errors.MAX_NUMBERS / 1e6:.0f} million numbers"
        in page
    )
    assert f"| {errors.MAX_TEXT / 1e6:.0f} MB, {errors.MAX_LINES / 1e6:g} million lines" in page


def test_a_board_that_still_samples_for_a_host_that_died_is_stopped(tmp_path: Path) -> None:
    board = ScriptedBoard(SAMPLES)
    board.write(encode(Start(), 0))
    time.sleep(0.01)
    board._stream()  # DATA is under way before HELLO and DESCRIBE are
    assert capture(board, SETTINGS, tmp_path / "s").info.verdict == "OK"
