"""Captures from the bench's double over a real pty and a real socket, sixteen times as fast as life."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from bench_double import LINES, ROOT, double

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import StationError
from daq.port import PortDescription
from daq.ports import probe
from daq.session import recover, verify

FAST = ("--speed", "16", "--seed", "5")
SETTINGS = CaptureSettings(check_clock=False)


@pytest.mark.parametrize("line", LINES)
def test_a_release_is_captured_where_it_happened(tmp_path: Path, line: str) -> None:
    with double(tmp_path, line, *FAST, "--release-ms", "0") as bench:
        session = capture(bench.port, SETTINGS, tmp_path / "s")
        truth = bench.truth()["releases"][0]
    window = session.assembly().window
    assert window is not None
    assert window.trigger is not None
    assert 0 <= window.trigger - truth["sample"] <= 1
    recording = session.recording()
    assert (recording.trigger, recording.samples.shape) == (256, (2, 9 * 256))
    assert session.info.verdict == "OK"
    assert verify(session.folder).ok


@pytest.mark.parametrize("line", LINES)
def test_several_captures_follow_each_other_on_one_double(tmp_path: Path, line: str) -> None:
    with double(tmp_path, line, *FAST, "--releases", "-25,v0.4,5", "--release-ms", "12") as bench:
        for number, verdict in enumerate(("OK", "USABLE WITH GAPS", "OK")):  # the blow saturates
            session = capture(bench.port, SETTINGS, tmp_path / str(number))
            assert session.info.verdict == verdict
            window = session.assembly().window
            # A busy computer stops late, and the operator goes on: the capture's first release is meant.
            truth = next(r for r in bench.truth()["releases"] if r["capture"] == number + 1)
            assert window is not None
            assert window.trigger is not None
            assert 0 <= window.trigger - truth["sample"] <= truth["hand_s"] * 256 + 1


def test_a_double_is_found_by_probing(tmp_path: Path) -> None:
    with double(tmp_path, "tcp", *FAST) as bench:
        found = probe(PortDescription(bench.port))
    assert found.answers
    assert [channel.quantity for channel in found.channels] == ["displacement", "acceleration"]


WATCHER = """
import sys
from pathlib import Path
from daq.capture import CaptureObserver, CaptureSettings, capture

class Printer(CaptureObserver):
    def block(self, first_index, samples):
        print(first_index, samples.shape[1], float(samples[0, -1]).hex(), flush=True)

capture(sys.argv[1], CaptureSettings(check_clock=False), Path(sys.argv[2]), Printer())
"""
KILLS = int(os.environ.get("STATION_KILLS", "2"))


@pytest.mark.skipif(os.name == "nt", reason="kill -9 is POSIX")
@pytest.mark.parametrize("seed", range(KILLS))
def test_a_killed_capture_keeps_every_sample_that_it_had_shown(tmp_path: Path, seed: int) -> None:
    with double(tmp_path, "pty", *FAST) as bench:
        watcher = subprocess.Popen(
            [sys.executable, "-c", WATCHER, bench.port, str(tmp_path / "s")],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert watcher.stdout is not None
        printed = [watcher.stdout.readline()]
        time.sleep(random.Random(seed).uniform(0.0, 0.8))
        watcher.send_signal(signal.SIGKILL)
        printed += watcher.communicate(timeout=10)[0].splitlines()
    blocks = [line.split() for line in printed if len(line.split()) == 3]
    session = recover(tmp_path / "s")
    assembly = session.assembly()
    assembly.window = None
    kept = assembly.recording()
    for first, count, last in blocks:
        at = int(first) + int(count) - 1 - assembly.start
        assert kept.samples[0, at] == float.fromhex(last)
    assert blocks
    assert verify(session.folder).ok
    assert json.loads((tmp_path / "s" / "session.json").read_text())["state"] in ("recovered", "sealed")


@pytest.mark.skipif(os.name == "nt", reason="file size limits are POSIX")
def test_a_disk_that_fills_up_during_the_capture_costs_nothing(tmp_path: Path) -> None:
    import resource

    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    settings = SETTINGS

    class Filler(CaptureObserver):
        def state(self, name: str, detail: str) -> None:
            if name == "triggered":
                resource.setrlimit(resource.RLIMIT_FSIZE, (8192, limits[1]))

    def fallback(error: StationError) -> Path:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        return tmp_path / "t"

    with double(tmp_path, "tcp", *FAST) as bench:
        try:
            session = capture(bench.port, settings, tmp_path / "s", Filler(), fallback)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert session.folder == tmp_path / "t"
    assert np.isfinite(session.recording().samples).all()
    assert session.info.verdict == "OK"
    assert verify(tmp_path / "t").ok
