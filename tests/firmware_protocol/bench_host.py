"""A board compiled for this computer, and the host's side of the conversation in its plainest form: for tests."""

import os
import select
import subprocess
import time
import tty
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from firmware_protocol import Ack, Data, Decoder, End, Frame, HelloRequest, Message, Nack, Stop, encode

M = TypeVar("M", bound=Message)


class Board:
    """A running firmware; a complaint of the sanitizers or a crash shows in its exit code."""

    def __init__(self, program: Path, *options: str) -> None:
        self.process = subprocess.Popen(
            [program, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        line = self.process.stdout.readline()
        assert line.startswith("port: "), line
        self.path = line.removeprefix("port: ").strip()

    def tell(self, word: str) -> None:
        """What happens at the rig: `open`, `close`, `hang up` or `block` (see `hardware_host.c`)."""
        assert self.process.stdin is not None
        self.process.stdin.write(word + "\n")
        self.process.stdin.flush()

    def end(self) -> None:
        _, complaint = self.process.communicate(timeout=10)
        assert self.process.returncode == 0, complaint


@dataclass
class BenchHost:
    """Open a port, send messages, collect all frames that come."""

    path: str
    frames: list[Frame] = field(default_factory=list)
    sequence: int = 0

    def __post_init__(self) -> None:
        self.port = os.open(self.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self.port)
        self.decoder = Decoder()

    def close(self) -> None:
        os.close(self.port)

    def send_bytes(self, data: bytes) -> None:
        while data:
            select.select([], [self.port], [], 1)
            data = data[os.write(self.port, data) :]

    def send(self, message: Message) -> int:
        self.send_bytes(encode(message, self.sequence))
        self.sequence += 1
        return self.sequence - 1

    def read(self, timeout: float) -> None:
        if select.select([self.port], [], [], timeout)[0]:
            self.frames += self.decoder.feed(os.read(self.port, 65536))

    def read_until(self, done: Callable[[], bool], seconds: float = 5) -> None:
        """Read until `done()`; a board that never gets there fails the test."""
        end = time.monotonic() + seconds
        while not done():
            left = end - time.monotonic()
            assert left > 0, f"the board never got there; last frames: {self.frames[-3:]}"
            self.read(min(left, 0.05))

    def next(self, kind: type[M], seconds: float = 5) -> M:
        """The next message of that type; frames before it are kept in `frames`."""
        begin = len(self.frames)

        def found() -> list[M]:
            return [frame.message for frame in self.frames[begin:] if isinstance(frame.message, kind)]

        self.read_until(lambda: bool(found()), seconds)
        return found()[0]

    def ask(self, message: Message, seconds: float = 5) -> Ack | Nack:
        """Send a request and return its answer."""
        sequence, begin = self.send(message), len(self.frames)
        answers: list[Ack | Nack] = []

        def answered() -> bool:
            answers[:] = [
                frame.message
                for frame in self.frames[begin:]
                if isinstance(frame.message, Ack | Nack) and frame.message.request_sequence == sequence
            ]
            return bool(answers)

        self.read_until(answered, seconds)
        return answers[0]

    def messages(self, kind: type[M]) -> list[M]:
        return [frame.message for frame in self.frames if isinstance(frame.message, kind)]

    def hello(self) -> None:
        self.send_bytes(b"\x00")
        self.send(HelloRequest())

    def stop(self) -> End:
        """STOP and all that follows."""
        ends = len(self.messages(End))
        assert isinstance(self.ask(Stop()), Ack)
        self.read_until(lambda: len(self.messages(End)) > ends)
        return self.messages(End)[-1]

    def samples(self) -> dict[int, bytes]:
        """The bytes of each sample that came, by index."""
        held = {}
        for data in self.messages(Data):
            size = data.channels * data.format.size
            for k in range(data.n):
                held[data.first_index + k] = data.samples[k * size : (k + 1) * size]
        return held
