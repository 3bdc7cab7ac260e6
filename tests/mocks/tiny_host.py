"""The least host that can talk to the double: it knows the wire and nothing of `daq`."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import subprocess
import sys
import time
import tty
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from firmware_protocol import (
    Data,
    Decoder,
    Describe,
    End,
    Hello,
    HelloRequest,
    Message,
    Resend,
    SampleFormat,
    Start,
    Stop,
    encode,
)

ROOT = Path(__file__).parents[2]


class TinyHost:
    """Opens `/dev/pts/N` or `socket://host:port`; keeps every message that came."""

    def __init__(self, address: str) -> None:
        self._socket = None
        if address.startswith("socket://"):
            name, port = address.removeprefix("socket://").split(":")
            self._socket = socket.create_connection((name, int(port)))
            self._file = self._socket.fileno()
        else:
            self._file = os.open(address, os.O_RDWR | os.O_NOCTTY)
            tty.setraw(self._file)
        self._sequence = 0
        self.decoder = Decoder()
        self.frames: list = []

    def close(self) -> None:
        if self._socket is not None:
            self._socket.close()
        else:
            os.close(self._file)

    def send(self, message: Message) -> int:
        data = encode(message, self._sequence)
        self._sequence += 1
        os.write(self._file, data)
        return self._sequence - 1

    def receive(self, seconds: float = 0.05) -> list:
        """Return the messages that came; raises OSError when the line is broken."""
        if not select.select([self._file], [], [], seconds)[0]:
            return []
        data = os.read(self._file, 65536)
        if not data:
            raise OSError("the other side has closed")
        frames = self.decoder.feed(data)
        self.frames += frames
        return [frame.message for frame in frames]

    def ask(self, message: Message, *kinds: type, seconds: float = 3.0) -> list:
        """Send until one message of each kind has come after it, in that order."""
        wanted, got, last = list(kinds), [], 0.0
        deadline = time.monotonic() + seconds
        while wanted and time.monotonic() < deadline:
            if time.monotonic() - last > 0.25:
                self.send(message)
                last = time.monotonic()
            for came in self.receive(0.02):
                if wanted and isinstance(came, wanted[0]):
                    got.append(came)
                    wanted.pop(0)
        assert not wanted, f"no {wanted[0].__name__} came in answer to {message}"
        return got

    def hello(self) -> tuple[Hello, Describe]:
        hello, describe = self.ask(HelloRequest(), Hello, Describe)
        return hello, describe

    def sample(self, count: int, seconds: float = 30.0, start: int = 0) -> list[Data]:
        """START, take DATA until `count` samples have come, STOP, and return all DATA to END.

        A wire that costs frames can cost END: an idle board repeats it for every STOP.
        """
        self.send(Start(start))
        data: list[Data] = []
        self.end = None
        stopped = 0.0
        deadline = time.monotonic() + seconds
        while self.end is None and time.monotonic() < deadline:
            for message in self.receive():
                if isinstance(message, Data):
                    data.append(message)
                if isinstance(message, End):
                    self.end = message
            enough = data and data[-1].first_index + data[-1].n >= count
            if enough and time.monotonic() - stopped > 0.25:
                self.send(Stop())
                stopped = time.monotonic()
        assert self.end is not None, "no END came"
        return data

    def resend(self, first: int, count: int) -> list[Message]:
        """Return the messages up to the ACK or NACK of a RESEND."""
        from firmware_protocol import Ack, Nack

        self.send(Resend(first, count))
        came: list[Message] = []
        deadline = time.monotonic() + 3.0
        while time.monotonic() < deadline:
            came += self.receive(0.02)
            if any(isinstance(message, Ack | Nack) for message in came):
                return came
        raise AssertionError("no answer to RESEND")


def values(data: list[Data], describe: Describe) -> tuple[np.ndarray, np.ndarray]:
    """Return indices and SI values (n, channels) of these DATA."""
    index = np.concatenate([d.first_index + np.arange(d.n) for d in data])
    numbers = np.concatenate(
        [np.frombuffer(d.samples, SampleFormat(d.format).code).reshape(d.n, d.channels) for d in data]
    )
    scale = np.array([c.scale for c in describe.channels])
    offset = np.array([c.offset for c in describe.channels])
    return index, numbers * scale + offset


@contextlib.contextmanager
def running_double(*arguments: str) -> Iterator[str]:
    """Run `python -m mocks` and yield its address; its end is checked."""
    process = subprocess.Popen(
        [sys.executable, "-m", "mocks", *arguments],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdin is not None
    try:
        line = process.stdout.readline()
        assert line.startswith("port: "), process.stderr.read() if process.stderr else ""
        yield line.removeprefix("port: ").strip()
    finally:
        process.stdin.close()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
        complaints = process.stderr.read() if process.stderr else ""
        process.stdout.close()
        if process.stderr:
            process.stderr.close()
    assert process.returncode == 0, complaints
    assert complaints == ""
