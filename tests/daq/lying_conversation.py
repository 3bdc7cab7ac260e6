"""A capture from a lying board by a clock of its own: hours of waiting take no time, and every run is the same."""

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np

from daq.capture import RESEND_FOR_S, CaptureSettings, capture
from daq.errors import StationError
from daq.link import ANSWER_S, BOOT_S, END_S, HELLO_FOR_S, FrameReader
from daq.session import Session
from firmware_protocol import Frame
from mocks.lying_board import LyingBoard


def longest_s(settings: CaptureSettings) -> float:
    """Return the longest time from the opened port to the sealed session, s, whatever a board without a holder does."""
    handshake = BOOT_S + HELLO_FOR_S + END_S + sum(ANSWER_S)
    settings_and_start = 2 * sum(ANSWER_S) + 3.0
    sampling = settings.rest_timeout_s + settings.trigger_timeout_s
    window = 2 * settings.duration_s + 5.0
    return handshake + settings_and_start + sampling + window + END_S + sum(ANSWER_S) + RESEND_FOR_S


SETTINGS = CaptureSettings(
    duration_s=1.0, pre_trigger_s=0.5, rest_s=0.25, rest_timeout_s=4.0, trigger_timeout_s=6.0, lost_limit=1.0
)
LIMIT_S = longest_s(SETTINGS)
BYTES_PER_S = 1e6
TICK_S = 0.01


class Clock:
    """Seconds that pass only when somebody waits."""

    def __init__(self) -> None:
        self.now = 1000.0

    def epoch(self) -> float:
        """Seconds since the epoch."""
        return 1e9 + self.now


class LyingPort:
    """A port behind which the lying board stands; 1 MB a second passes through it."""

    name = "lying"

    def __init__(self, board: LyingBoard, clock: Clock) -> None:
        self._board, self._clock, self._out = board, clock, b""

    def read(self) -> bytes:
        data, self._out = self._out + self._board.poll(self._clock.now), b""
        self._clock.now += len(data) / BYTES_PER_S
        return data

    def write(self, data: bytes) -> None:
        self._out += self._board.receive(data, self._clock.now)

    def close(self) -> None:
        pass


def reader_of(clock: Clock) -> type[FrameReader]:
    """The station's own reader, without a thread: it reads when a frame is waited for."""

    class WaitingReader(FrameReader):
        def _start(self) -> None:
            pass

        def close(self) -> None:
            pass

        def take(self, timeout: float) -> tuple[float, Frame] | None:
            until = clock.now + max(timeout, 1e-4)
            while self._queue.empty() and clock.now < until:
                try:
                    if not self.read_once():
                        clock.now = min(clock.now + TICK_S, until)
                except StationError as error:
                    self._queue.put(error)
            return super().take(0)

    return WaitingReader


@contextlib.contextmanager
def timeless(clock: Clock) -> Iterator[None]:
    """Let the station wait by this clock."""
    slow = SimpleNamespace(monotonic=lambda: clock.now, time=time.time, sleep=time.sleep)
    with contextlib.ExitStack() as stack:
        for name in ("daq.link.time", "daq.capture_stream.time", "daq.capture.time"):
            stack.enter_context(mock.patch(name, slow))
        stack.enter_context(mock.patch("daq.raw_log.host_time", clock.epoch))
        for name in ("os.fsync", "os.fdatasync"):  # nothing here must outlive a crash
            stack.enter_context(mock.patch(name))
        stack.enter_context(mock.patch("daq.link.FrameReader", reader_of(clock)))
        yield


@dataclass(frozen=True)
class Told:
    """How a conversation ended: verdict, seconds by its own clock, bytes logged, what was wrong."""

    seed: int
    board: LyingBoard
    error: str
    verdict: str
    elapsed_s: float
    log_bytes: int
    wrong: str

    @property
    def lies(self) -> str:
        """What the board did."""
        return f"seed {self.seed}: {self.board.plan.behaviours} {self.board.liar.told[:6]}"


def converse(seed: int, folder: Path) -> Told:
    """Capture from the lying board of this seed into the new folder, and hold the session against the truth."""
    board, clock = LyingBoard(seed), Clock()
    begun, error = clock.now, ""
    with timeless(clock):
        try:
            capture(LyingPort(board, clock), SETTINGS, folder)
        except StationError as problem:
            error = f"{type(problem).__name__}: {problem}"
        return _judged(seed, board, folder, error, clock.now - begun)


def _judged(seed: int, board: LyingBoard, folder: Path, error: str, elapsed: float) -> Told:
    if not (folder / "session.json").exists():
        return Told(seed, board, error, "", elapsed, 0, "" if error else "no session and no error")
    session = Session.open(folder)
    size = (folder / "raw.log").stat().st_size
    wrong = _difference(board, session) if session.info.verdict == "OK" else ""
    return Told(seed, board, error, session.info.verdict, elapsed, size, wrong)


def _difference(board: LyingBoard, session: Session) -> str:
    """Return where samples called OK are not what stood at the board's input; empty when all are.

    What a board says of its channels before START nobody can check: its numbers are compared, as it scales them.
    """
    recording, assembly = session.recording(), session.assembly()
    if not recording.valid.all():
        return "samples are missing"
    if recording.samples.shape[0] != 2 or abs(recording.rate / 256.0 - 1) > 0.005:
        return f"{recording.samples.shape[0]} channels at {recording.rate:g} Hz"
    assert assembly.description is not None
    said = assembly.description.channels
    at = np.arange(assembly.start, assembly.stop) % len(board.values)
    truth = board.values[at] * [c.scale for c in said] + [c.offset for c in said]
    other = np.flatnonzero((recording.samples != truth.T).any(axis=0))
    return f"{len(other)} samples are wrong, from {assembly.start + int(other[0])} on" if len(other) else ""
