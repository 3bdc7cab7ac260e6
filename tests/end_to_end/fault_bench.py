"""One fault of docs/faults.md: the page's table as data, the double on a real line, `station capture` upon it."""

import contextlib
import dataclasses
import io
import os
import socket
import time
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from unittest import mock

from daq import port as port_module
from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import DataLost, LinkLost
from daq.port import Port
from daq.session import Session, verify
from mocks.in_process import running
from station import cli
from station.operations import new_session

PAGE = Path(__file__).parents[2] / "docs" / "faults.md"
COLUMNS = ["fault", "exit", "words", "gaps", "verdict", "reason"]
INJECTED = tomllib.loads((Path(__file__).parent / "faults.toml").read_text(encoding="utf-8"))
BECAUSE = ", because"
LINES = ("pty", "tcp")
NOBODY = 65534
REAL_TIME = "--speed=1"
RELEASE = "--release="  # goes to `station capture`; every other option to the double


@dataclasses.dataclass(frozen=True)
class Promise:
    """A row of the table: what is done to the board, and how `station capture` must end."""

    fault: str
    lines: tuple[str, ...]
    injected: str
    code: int
    words: str
    gaps: str
    verdict: str
    reason: str


@dataclasses.dataclass(frozen=True)
class Outcome:
    """How a capture ended: exit code, what it said on stderr, its session if it left one."""

    code: int
    said: str
    session: Session | None


def promises(page: Path = PAGE) -> tuple[Promise, ...]:
    """Return what the page's tables promise; AssertionError where there is none.

    A row may hold several faults that end alike, with semicolons between them. A table of three columns names in its
    head the verdict of all its rows, and says what to do.
    """
    found: list[Promise] = []
    header: list[str] = []
    for line in page.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            header = []
        elif not header:
            header = cells
        elif cells[0].strip("-") and header == COLUMNS:
            found += _promised(*cells)
        elif cells[0].strip("-") and header[1].endswith(BECAUSE):
            verdict = header[1].removesuffix(BECAUSE)
            found += _promised(cells[0], "0", f"verdict: {verdict.split()[0]}", "none", verdict, cells[1])
    assert found, "no table of faults"
    return tuple(found)


def _promised(faults: str, code: str, words: str, gaps: str, verdict: str, reason: str) -> list[Promise]:
    """The promises of a row."""
    return [
        Promise(name, lines, INJECTED[name], int(code), _plain(words), gaps, verdict, _plain(reason))
        for name, lines in map(_lines, faults.split("; "))
    ]


def _lines(fault: str) -> tuple[str, tuple[str, ...]]:
    """Return a fault's name and its lines: both, or the one named in brackets."""
    for line in LINES:
        if fault.endswith(f" ({line})"):
            return fault.removesuffix(f" ({line})"), (line,)
    return fault, LINES


def _plain(cell: str) -> str:
    return "" if cell == "-" else cell.strip("`")


@contextlib.contextmanager
def board(line: str, *arguments: str) -> Iterator[str]:
    """Serve the double from a thread, on a real pty or socket; yield the name of its port."""
    with running(*(["--pty"] if line == "pty" else ["--tcp", "0"]), *arguments) as address:
        yield address


@contextlib.contextmanager
def without_clock_check() -> Iterator[None]:
    """Capture without comparing clocks: a sped-up double keeps another time than this computer."""
    checked = new_session.capture_settings

    def settings(*given: object, **timing: object) -> object:
        return dataclasses.replace(checked(*given, **timing), check_clock=False)  # type: ignore[arg-type]

    with mock.patch.object(new_session, "capture_settings", settings):
        yield


def station_capture(port: str, folder: Path, *arguments: str, clock: bool = False) -> Outcome:
    """Call the command as an operator does; `clock` holds the board's against this computer's."""
    printed, said = io.StringIO(), io.StringIO()
    words = ["capture", "--port", port, "--session", str(folder), "--no-viewer", *arguments]
    checked = contextlib.nullcontext() if clock else without_clock_check()
    with checked, contextlib.redirect_stdout(printed), contextlib.redirect_stderr(said):
        code = cli.run(words)
    session = Session.open(folder) if (folder / "session.json").exists() else None
    return Outcome(code, said.getvalue(), session)


def inject(promise: Promise, line: str, folder: Path, speed: float, seed: int, *timing: str) -> Outcome:
    """Do to the board what the table says, and capture from it."""
    double = ("--speed", str(speed), "--seed", str(seed))
    parts = promise.injected.split()
    timing += tuple(part for part in parts if part.startswith(RELEASE))
    if promise.injected in SPECIAL:
        return SPECIAL[promise.injected](line, folder, double, timing)
    faults = [
        word
        for part in parts
        if not part.startswith(RELEASE)
        for word in ([part] if part[0] == "-" else ["--fault", part])
    ]
    with board(line, *double, *faults) as port:
        return station_capture(port, folder / "s", *timing, clock=REAL_TIME in promise.injected)


class Silence(CaptureObserver):
    """When the last samples of a board came, and when its silence was announced (s, this computer's clock)."""

    def __init__(self) -> None:
        self.last = self.announced = 0.0

    def block(self, first_index: int, samples: object) -> None:
        self.last = time.monotonic()

    def state(self, name: str, detail: str) -> None:
        if "nothing came" in detail:
            self.announced = time.monotonic()


def silence(line: str, folder: Path, at: float = 2.0) -> tuple[float, float]:
    """Let a board fall silent `at` seconds into its stream, in real time.

    Return how long after its last samples this was announced, and the board given up (s).
    """
    watch = Silence()
    with board(line, "--seed", "5", "--fault", f"stall:30@{at:g}") as port:
        try:
            capture(port, CaptureSettings(), folder / "s", watch)
        except LinkLost:
            return watch.announced - watch.last, time.monotonic() - watch.last
    raise AssertionError("a board that had stalled was recorded to the end")


def _busy(line: str, folder: Path, double: tuple[str, ...], timing: tuple[str, ...]) -> Outcome:
    with board(line, *double) as port, _held(port):
        return station_capture(port, folder / "s", *timing)


@contextlib.contextmanager
def _held(port: str) -> Iterator[None]:
    """Hold the port as another program does."""
    if port.startswith("socket://"):
        host, _, number = port.removeprefix("socket://").partition(":")
        with socket.create_connection((host, int(number)), timeout=5):
            time.sleep(0.2)
            yield
        return
    import fcntl

    descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        yield
    finally:
        os.close(descriptor)


def _forbidden(line: str, folder: Path, double: tuple[str, ...], timing: tuple[str, ...]) -> Outcome:
    """Permissions do not bind root, who therefore steps down for as long as the port is opened."""
    real = port_module.open_port

    def step_down(name: str) -> Port:
        is_root = os.geteuid() == 0
        if is_root:
            os.seteuid(NOBODY)
        try:
            return real(name)
        finally:
            if is_root:
                os.seteuid(0)

    with board(line, *double) as port, mock.patch("daq.capture.open_port", step_down):
        os.chmod(port, 0)
        return station_capture(port, folder / "s", *timing)


def _replugged(line: str, folder: Path, double: tuple[str, ...], timing: tuple[str, ...]) -> Outcome:
    """Pull the cable in mid-capture, plug it in again: the next capture from the same name is whole."""
    name = folder / "port"
    with board(line, *double, "--fault", "unplug@5") as port:
        first = station_capture(_named(name, port), folder / "cut", *timing)
        assert first.code == 6, first.said
        if line == "tcp":
            return station_capture(port, folder / "s", *timing)
    with board(line, *double) as port:
        return station_capture(_named(name, port), folder / "s", *timing)


def _named(name: Path, port: str) -> str:
    """Give a pty a lasting name, as /dev/serial/by-id does."""
    if port.startswith("socket://"):
        return port
    name.unlink(missing_ok=True)
    name.symlink_to(port)
    return str(name)


Special = Callable[[str, Path, tuple[str, ...], tuple[str, ...]], Outcome]
SPECIAL: dict[str, Special] = {
    "port held": _busy,
    "chmod 0": _forbidden,
    "unplug@5, plugged in again": _replugged,
}


def broken_promises(promise: Promise, outcome: Outcome) -> list[str]:
    """Return where the outcome is not what was promised; empty when it is."""
    found = []
    if outcome.code != promise.code:
        found.append(f"exit code {outcome.code}, not {promise.code}")
    if promise.words not in " ".join(outcome.said.split()):
        found.append(f"not said: {promise.words!r}")
    if "Traceback" in outcome.said or "fault of this program" in outcome.said:
        found.append("a traceback")
    if promise.verdict == "-":
        return found + (["a session was left"] if outcome.session else [])
    return found + _of_session(promise, outcome.session)


def _of_session(promise: Promise, session: Session | None) -> list[str]:
    if session is None:
        return ["no session was left"]
    found = []
    verdict = session.verdict
    reasons = " ".join(verdict.reasons) if verdict else ""
    if verdict is None or verdict.grade.value not in promise.verdict.split(" or "):
        found.append(f"verdict {verdict}, not {promise.verdict}")
    if promise.reason not in reasons:
        found.append(f"no reason {promise.reason!r} among {reasons!r}")
    gaps = _gaps(session)
    if not gaps <= set(promise.gaps.split(" or ")):
        found.append(f"gaps by {', '.join(sorted(gaps))}, not {promise.gaps}")
    if not verify(session.folder).ok:
        found.append("station verify refuses the session")
    return found


def _gaps(session: Session) -> set[str]:
    try:
        return {gap.reason for gap in session.recording().gaps} or {"none"}
    except DataLost:
        return {"-"}
