"""Killed captures and failing disks: what is on the disk afterwards, against what the wire had delivered.

A relay between the double and `station capture` notes when it handed on which bytes: that log is the truth.
"""

import contextlib
import json
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from bench.writers import rows
from daq.raw_log import Kind, read
from daq.session import Session, verify
from firmware_protocol import Data, Decoder, Stop, encode

TITLE = "Storage"
ROOT = Path(__file__).resolve().parent.parent
PROMISE_S = 0.25
DURATION_S = 4.0
AT_ONCE = 8


class Relay:
    """Hands the double's bytes on to one host, and notes when."""

    def __init__(self, to: str) -> None:
        host, _, port = to.removeprefix("socket://").rpartition(":")
        self._board = socket.create_connection((host, int(port)), 10)
        self._quiet()
        self._server = socket.create_server(("127.0.0.1", 0))
        self._server.settimeout(60)
        self.port = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        self.delivered: list[tuple[float, bytes]] = []
        self.connected = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def _quiet(self) -> None:
        """Stop what the capture killed before has left running, so that its samples are not taken for the next one's."""
        self._board.sendall(b"\0" + encode(Stop(), 0))
        self._board.settimeout(0.3)
        end = time.monotonic() + 5
        with contextlib.suppress(TimeoutError):  # quiet at last
            while self._board.recv(4096):
                if time.monotonic() > end:
                    raise RuntimeError(
                        "the board of this bench does not stop: its samples would be the next capture's"
                    )
        self._board.settimeout(None)

    def _run(self) -> None:
        try:
            self._host, _ = self._server.accept()
            self.connected.set()
            threading.Thread(target=self._back, daemon=True).start()
            while data := self._board.recv(4096):
                self._host.sendall(data)
                self.delivered.append((time.monotonic(), data))
        except OSError:
            return

    def _back(self) -> None:
        try:
            while data := self._host.recv(4096):
                self._board.sendall(data)
        except OSError:
            return

    def until(self, when: float) -> bytes:
        """Every byte handed on before `when`."""
        return b"".join(data for at, data in self.delivered if at <= when)

    def close(self) -> None:
        for one in (self._board, self._server, getattr(self, "_host", None)):
            if one is not None:
                one.close()


@dataclass(frozen=True)
class Killed:
    """One killed capture: samples due on the disk, samples of these not there, and what is wrong."""

    due: int
    missing: int
    wrong: str


def start_double(seed: int) -> tuple["subprocess.Popen[str]", str]:
    command = [sys.executable, "-m", "mocks", "--tcp", "0", "--seed", str(seed)]
    process = subprocess.Popen(command, cwd=ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    return process, process.stdout.readline().removeprefix("port: ").strip()


def station(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "station", *map(str, arguments)]


def kill_some(folder: Path, seeds: range) -> list[Killed]:
    """Kill captures from one double, one after the other."""
    double, port = start_double(seeds[0])
    try:
        return [kill_one(folder, port, seed) for seed in seeds]
    finally:
        double.terminate()
        double.communicate(timeout=10)


def kill_one(folder: Path, port: str, seed: int) -> Killed:
    """Kill one capture at a random moment after it had the port, recover it, and compare."""
    relay = Relay(port)
    session = folder / f"killed_{seed}"
    command = station(
        "capture", "--port", relay.port, "--session", session, "--duration", DURATION_S, "--no-viewer"
    )
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        if not relay.connected.wait(60):
            return Killed(0, 0, "it never had the port")
        time.sleep(random.Random(seed).uniform(0.0, DURATION_S + 6.0))
        now = time.monotonic()
        process.send_signal(signal.SIGKILL)
        process.wait(10)
    finally:
        process.kill()
        relay.close()
    return compare(session, relay.until(now - PROMISE_S))


def compare(session: Path, due: bytes) -> Killed:
    """Recover a session by the command and hold it to the bytes that were due."""
    sent = samples_of(due)
    if not (session / "raw.log").exists():
        return Killed(len(sent), len(sent), "")
    done = subprocess.run(station("recover", session), cwd=ROOT, capture_output=True, text=True, timeout=120)
    if done.returncode:
        return Killed(len(sent), len(sent), done.stderr.strip())
    received = b"".join(r.payload for r in read(session / "raw.log").records if r.kind is Kind.RECEIVED)
    kept = samples_of(received)
    missing = sum(kept.get(at) != frame for at, frame in sent.items())
    opened = Session.open(session)
    wrong = ""
    if kept:
        assembly = opened.assembly()
        assembly.window = None
        decoded = assembly.recording()
        first, valid = assembly.start, decoded.valid
        there = sum(0 <= at - first < len(valid) and bool(valid[at - first]) for at in sent)
        wrong = "" if there == len(sent) else f"{len(sent) - there} samples are not in the recording"
    if not verify(session).ok:
        wrong = wrong or "; ".join(verify(session).problems)
    return Killed(len(sent), missing, wrong)


def samples_of(data: bytes) -> dict[int, bytes]:
    """The samples in the bytes of a wire, by index, as the board sent them."""
    found: dict[int, bytes] = {}
    for frame in Decoder().feed(data):
        message = frame.message
        if isinstance(message, Data):
            size = len(message.samples) // max(message.n, 1)
            for i in range(message.n):
                found[message.first_index + i] = bytes(message.samples[i * size : (i + 1) * size])
    return found


def fill(folder: Path) -> None:
    with (folder / "filler").open("wb", buffering=0) as file:
        try:
            while file.write(bytes(4096)):
                pass
        except OSError:
            return


def remount_read_only(folder: Path) -> None:
    subprocess.run(["mount", "-o", "remount,ro", str(folder)], check=True, capture_output=True)


FAULTS = {
    "disk full in mid-capture": fill,
    "folder deleted in mid-capture": lambda folder: shutil.rmtree(folder / "s"),
    "folder renamed in mid-capture": lambda folder: (folder / "s").rename(folder / "moved"),
    "disk unmounted in mid-capture": lambda folder: subprocess.run(["umount", "-l", str(folder)], check=True),
    "disk full before": fill,
    "disk read-only before": remount_read_only,
}


def fault_one(folder: Path, name: str, seed: int) -> str:
    """Let a disk fail during (or before) one capture; return what was wrong, nothing when nothing was lost."""
    disk, spare = folder / f"disk_{seed}", folder / f"spare_{seed}"
    disk.mkdir()
    made = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(disk)], capture_output=True, text=True
    )
    if made.returncode:
        return f"no disk to break: {made.stderr.strip()}"
    double, port = start_double(seed)
    relay = Relay(port)
    before = name.endswith("before")
    if before:
        FAULTS[name](disk)
    options = ("--duration", DURATION_S, "--spare", spare, "--no-viewer", "--json")
    command = station("capture", "--port", relay.port, "--session", disk / "s", *options)
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        if not relay.connected.wait(60):
            return "it never had the port"
        time.sleep(random.Random(seed).uniform(1.0, DURATION_S + 1.0))
        if not before:
            FAULTS[name](disk)
        said, complaints = process.communicate(timeout=120)
    finally:
        process.kill()
        double.terminate()
        double.communicate(timeout=10)
        relay.close()
        subprocess.run(["umount", "-l", str(disk)], check=False, capture_output=True)
    return lost_in(said, complaints, process.returncode, spare, relay)


def lost_in(said: str, complaints: str, code: int, spare: Path, relay: Relay) -> str:
    if code:
        return f"exit code {code}: {complaints.strip().splitlines()[-1:]}"
    session = Path(json.loads(said)["session"])
    if spare not in session.parents:
        return f"the session is in {session}"
    kept = b"".join(r.payload for r in read(session / "raw.log").records if r.kind is Kind.RECEIVED)
    sent = samples_of(relay.until(time.monotonic()))
    there = samples_of(kept)
    missing = sum(there.get(at) != frame for at, frame in sent.items() if at <= max(there, default=-1))
    if not sent or missing or not there:
        return f"{missing} of {len(sent)} samples are missing"
    return "" if verify(session).ok else "; ".join(verify(session).problems)


def run(quick: bool) -> str:
    kills, faults = (16, 1) if quick else (200, 5)
    with tempfile.TemporaryDirectory() as name, ThreadPoolExecutor(AT_ONCE) as pool:
        folder = Path(name)
        series = pool.map(lambda i: kill_some(folder, range(i, kills, AT_ONCE)), range(AT_ONCE))
        killed = [one for part in series for one in part]
        cases = [(name, 1000 * (i + 1) + seed) for i, name in enumerate(FAULTS) for seed in range(faults)]
        ended = list(pool.map(lambda case: fault_one(folder, *case), cases))
    bad = [
        f"kill {i}: {one.wrong or f'{one.missing} missing'}"
        for i, one in enumerate(killed)
        if one.wrong or one.missing
    ]
    bad += [f"{case[0]}: {what}" for case, what in zip(cases, ended, strict=True) if what]
    for line in bad:
        print(line, file=sys.stderr)
    lines = [
        "| what | tried | nothing lost |",
        "|---|---:|---:|",
        f"| `kill -9` at a random moment, then `station recover` | {kills} | {sum(not (k.wrong or k.missing) for k in killed)} |",
    ]
    lines.append(
        "| disk full, read-only or unmounted, folder deleted or renamed "
        f"| {len(ended)} | {sum(not what for what in ended)} |"
    )
    with tempfile.TemporaryDirectory() as name:
        of_writers, wrong = rows(Path(name), quick)
    lines, bad = lines + of_writers, bad + wrong
    for line in wrong:
        print(line, file=sys.stderr)
    due = sum(k.due for k in killed)
    lines.append("")
    lines.append(
        f"Of {due} samples that came more than {PROMISE_S * 1e3:.0f} ms before a kill {sum(k.missing for k in killed)} are missing."
    )
    if bad:
        lines += ["", "Failed: " + "; ".join(bad[:10])]
    return "\n".join(lines)
