"""`station capture --lines` and `station profile`: a board that prints in real time; contradictions in a sentence."""

import json
import os
import threading
import time
import tty

import numpy as np
import pytest

from daq.session import Session
from mocks.generate import draw
from station.cli import run


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--port", "p", "--column", "displacement=2"), "--column belongs to --lines"),
        (("--port", "p", "--lines", "--source", "audio"), "two kinds of board"),
        (("--lines",), "name the port whose lines"),
        (("--port", "p", "--profile", "nosuch"), "there is no profile 'nosuch'"),
        (("--source", "x.doc:A"), "is no source"),
        (("--port", "p", "--lines", "--unit", "mm"), "write QUANTITY=VALUE"),
    ],
)
def test_contradictions_are_refused_in_a_sentence(arguments, says, capsys):
    assert run(["capture", "--no-viewer", *arguments]) == 2
    assert says in capsys.readouterr().err


class Printer(threading.Thread):
    """Prints a simulated release on a pseudo terminal in real time, over and over, after some rest."""

    def __init__(self, rest_s: float) -> None:
        super().__init__(daemon=True)
        self.truth = draw(None, 0.0, 5)
        self.master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(self.master, False)
        self.port = os.ttyname(slave)
        self._slave = slave
        self._rest = rest_s
        self.stop = threading.Event()

    def run(self) -> None:
        x, random = self.truth, np.random.default_rng(1)
        rest = int(self._rest * x.rate)
        began = time.monotonic()
        for i in range(rest + len(x.displacement) - 100):
            time.sleep(max(0.0, began + i / x.rate - time.monotonic()))
            at = 100 + max(i - rest, 0) if i >= rest else int(random.integers(0, 150))
            line = f"{round(1e6 * i / x.rate)},{1e6 * x.displacement[at]:.2f},{x.acceleration[at]:.6f}\r\n"
            if self.stop.is_set():
                return
            try:
                os.write(self.master, line.encode())
            except BlockingIOError:
                continue


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_board_that_prints_is_profiled_captured_and_identified(capsys):
    told = ["--column", "displacement=2", "--unit", "displacement=um"]
    told += ["--column", "acceleration=3", "--unit", "acceleration=m/s^2"]
    board = Printer(rest_s=14.0)
    board.start()
    try:
        assert run(["profile", "bench", "--port", board.port, *told, "--json"]) == 0
        profile = json.loads(capsys.readouterr().out)
        assert profile["format"]["clock"] == {"kind": "stamps", "column": "1", "scale": 1e-6}
        assert profile["rate_hz"] == pytest.approx(256.0, rel=1e-5)
        command = ["capture", "--no-viewer", "--port", board.port, "--profile", "bench", "--mass", "21.36"]
        assert run([*command, "--session", "s", "--duration", "5", "--json"]) == 0
    finally:
        board.stop.set()
    found = json.loads(capsys.readouterr().out)
    verdict = Session.open("s").verdict
    assert verdict is not None
    assert verdict.grade.value == "OK"
    recording = Session.open("s").recording()
    assert recording.valid.all()
    truth = draw(None, 0.0, 5).truth
    wavelet = found["identification"]["wavelet"]["stiffness"]
    assert wavelet["value"] == pytest.approx(truth["stiffness"], rel=3e-4)
