"""A board that lies: what it does wrong is drawn from its seed, message by message and in the whole conversation.

It has no port and reads no clock, as `board`, and no physics but a closed form: the truth is `values`, what stood at
its input at each instant of sampling. What it says of a sample's time is true unless its clock is among the lies.
"""

from __future__ import annotations

from dataclasses import dataclass
from zlib import crc32

import numpy as np

from firmware_protocol import (
    TYPE_OF,
    Ack,
    ChannelDescription,
    Config,
    Data,
    Decoder,
    Describe,
    End,
    Heartbeat,
    Hello,
    HelloRequest,
    Message,
    Nack,
    NackCode,
    OtherVersion,
    Resend,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
)
from mocks.lies import KINDS, Liar

RATE = 256.0
RELEASE = 300
LENGTH = 4000
PER_FRAME = 16
HELD = 12 * 256
BEHAVIOURS = (
    "pause", "jump", "drop", "false drop", "clock back", "clock still", "clock rate", "fast", "slow",
    "reboot", "silent reboot", "stall", "heartbeats only", "babble", "noise", "no end", "early end", "wrong end",
    "resend nothing", "resend more", "resend others", "resend for ever", "resend refused", "acknowledges nothing",
)  # fmt: skip


def motion(random: np.random.Generator, length: int = LENGTH) -> np.ndarray:
    """Return displacement (m) and acceleration (m/s^2) of a mass let go at sample RELEASE, with noise, (length, 2)."""
    time = (np.arange(length) - RELEASE) / RATE
    omega, decay = 2 * np.pi * random.uniform(3.0, 6.0), random.uniform(0.1, 0.6)
    pole = -decay + 1j * omega
    swing = 0.02 * np.exp(pole * np.maximum(time, 0.0)) * (1.0 + 1j * decay / omega)
    pair = np.stack([swing.real, np.where(time > 0, (pole**2 * swing).real, 0.0)], axis=1)
    return np.asarray(pair + random.standard_normal((length, 2)) * [5e-6, 0.01])


@dataclass(frozen=True)
class Plan:
    """What one board does wrong: kinds of lies about messages with their odds, behaviours and when they begin."""

    kinds: tuple[str, ...]
    odds: float
    behaviours: tuple[str, ...]
    strikes: int
    amount: int


def plan_of(random: np.random.Generator) -> Plan:
    """Draw what goes wrong: nothing, lies about messages, behaviours, or both."""
    kinds: tuple[str, ...] = ()
    if random.random() < 0.75:
        some = random.permutation(np.array(list(KINDS)))[: int(random.integers(1, 5))]
        kinds = tuple(str(kind) for kind in some)
    most = int(random.choice([0, 0, 1, 1, 2, 3]))
    behaviours = tuple(str(b) for b in random.permutation(np.array(BEHAVIOURS))[:most])
    odds = float(10.0 ** random.uniform(-2.5, -0.5))
    return Plan(
        kinds, odds, behaviours, int(random.integers(50, 700)), int(random.choice([1, 2, 7, 16, 40, 400]))
    )


class LyingBoard:
    """One board: `receive` bytes of the host, `poll` what leaves at a time (s). `values` is the truth, (n, 2)."""

    def __init__(self, seed: int) -> None:
        random = np.random.default_rng([seed, 11])
        self.plan = plan_of(random)
        self.values = motion(random)
        self.liar = Liar(random, self.plan.kinds, self.plan.odds)
        self._random = random
        self._decoder = Decoder()
        self._boot = 1
        self._started: float | None = None
        self._taken = self._labelled = self._dropped = self._check = 0
        self._sent: dict[int, tuple[int, int]] = {}
        self._end = End(0, 0, 0)
        self._over = False
        self._endless: bytes | None = None
        self._beat = 0.0
        self._struck: set[str] = set()

    def does(self, behaviour: str) -> bool:
        """Whether the board does this."""
        return behaviour in self.plan.behaviours

    def receive(self, data: bytes, now: float) -> bytes:
        """Take bytes of the host; return the answers."""
        frames = self._decoder.feed(data)
        if self.does("stall") and self._taken > self.plan.strikes:
            return b""
        return b"".join(self._answer(frame.sequence, frame.message, now) for frame in frames)

    def poll(self, now: float) -> bytes:
        """Return the bytes that leave the board at this time."""
        out = b""
        if self.does("noise") and self._late():
            out += self._random.bytes(500)
        if self.does("babble") and self._late():
            out += self.liar.send(Heartbeat(self._taken, 0, 0)) * 5
        if self._endless is not None:
            out += self._endless
        if self._started is not None:
            out += self._stream(now)
        elif now - self._beat >= 0.5:
            self._beat = now
            out += self.liar.send(Heartbeat(int(now * 1e6), 0, 0))
        return out

    def _late(self) -> bool:
        return self._taken > self.plan.strikes

    def _once(self, behaviour: str) -> bool:
        """Whether this strikes now, for the first time."""
        if not self.does(behaviour) or behaviour in self._struck or not self._late():
            return False
        self._struck.add(behaviour)
        return True

    def _answer(self, sequence: int, request: Message | OtherVersion, now: float) -> bytes:
        say = self.liar.send
        if isinstance(request, HelloRequest | OtherVersion):
            return say(Hello(self._boot, 1_000_000, board="lying")) + say(self._description())
        if isinstance(request, TimeSync):
            return say(TimeSync(request.host_time_us, int(now * 1e6)))
        if isinstance(request, Resend):
            return self._again(sequence, request)
        if not isinstance(request, Config | Start | Stop):
            return b""
        out = b"" if self.does("acknowledges nothing") else say(Ack(sequence, TYPE_OF[type(request)]))
        if isinstance(request, Config):
            return out + say(self._description())
        if isinstance(request, Start):
            if self._started is None:
                self._begin(now)
            return out
        return out + self._finish()

    def _description(self) -> Describe:
        about = (("x", "displacement", "m", 0.05), ("a", "acceleration", "m/s^2", 50.0))
        return Describe(
            SampleFormat.F64,
            tuple(ChannelDescription(n, q, u, 1.0, 0.0, RATE, -w, w, 1e-6) for n, q, u, w in about),
        )

    def _begin(self, now: float) -> None:
        self._started, self._over = now, False
        self._taken = self._labelled = self._dropped = self._check = 0
        self._sent, self._endless = {}, None

    def _finish(self) -> bytes:
        if self._started is not None:
            self._started = None
            wrong = self.plan.amount if self.does("wrong end") else 0
            self._end = End(self._labelled + wrong, self._dropped, self._check)
        return b"" if self.does("no end") else self.liar.send(self._end)

    def _stream(self, now: float) -> bytes:
        """Return the frames that are due."""
        assert self._started is not None
        pace = RATE * (10.0 if self.does("fast") else 0.1 if self.does("slow") else 1.0)
        out = b""
        while self._started is not None and self._taken + PER_FRAME <= (now - self._started) * pace:
            if self.does("stall") and self._late():
                return out
            if self.does("heartbeats only") and self._late():
                self._taken += PER_FRAME
                return out + self.liar.send(Heartbeat(self._taken, 0, 0))
            if self._once("reboot") or self._once("silent reboot"):
                self._boot, self._started = 2, None
                return out if "silent reboot" in self._struck else out + self._answer(0, HelloRequest(), now)
            if self._once("early end"):
                return out + self._finish()
            out += self._next()
        return out

    def _next(self) -> bytes:
        """Take the samples of one frame and return it."""
        dropped = 0
        if self._once("pause"):
            self._taken += self.plan.amount
        if self._once("jump"):
            self._labelled += self.plan.amount
        if self._once("drop"):
            dropped = self.plan.amount
            self._taken, self._labelled = self._taken + dropped, self._labelled + dropped
            self._dropped += dropped
        if self._once("false drop"):
            dropped += self.plan.amount
        data = self._data(self._labelled, self._taken, PER_FRAME, dropped)
        self._sent[self._labelled] = (self._taken, PER_FRAME)
        self._check = crc32(data.samples, self._check)
        self._taken, self._labelled = self._taken + PER_FRAME, self._labelled + PER_FRAME
        return self.liar.send(data)

    def _data(self, label: int, taken: int, n: int, dropped: int = 0) -> Data:
        at = np.arange(taken, taken + n) % len(self.values)
        return Data(
            label,
            self._time_us(taken),
            dropped,
            n,
            2,
            SampleFormat.F64,
            self.values[at].astype("<f8").tobytes(),
        )

    def _time_us(self, taken: int) -> int:
        if self.does("clock still"):
            return 5
        time = 10.0 + taken / RATE * (1.03 if self.does("clock rate") else 1.0)
        if self.does("clock back") and taken > self.plan.strikes:
            time -= 3.0
        return round(time * 1e6)

    def _again(self, sequence: int, wanted: Resend) -> bytes:
        if self.does("resend nothing"):
            return b""
        refused = self.does("resend refused")
        more = self.plan.amount if self.does("resend more") else 0
        parts = [] if refused else self._held(wanted.first - more, wanted.first + wanted.count + more)
        if self.does("resend others"):
            parts = [(label, taken + 3, n) for label, taken, n in parts]
        out = b"".join(self.liar.send(self._data(*part)) for part in parts)
        if self.does("resend for ever"):
            self._endless = out
            return out
        complete = sum(n for _, _, n in parts) >= wanted.count
        code = TYPE_OF[Resend]
        return out + self.liar.send(
            Ack(sequence, code) if complete else Nack(sequence, code, NackCode.NOT_HELD, "too old")
        )

    def _held(self, first: int, stop: int) -> list[tuple[int, int, int]]:
        """List the samples sent among these, as (label, instant, n)."""
        found = []
        for label, (taken, n) in self._sent.items():
            a, b = max(first, label, self._labelled - HELD), min(stop, label + n)
            if a < b:
                found.append((a, taken + a - label, b - a))
        return found
