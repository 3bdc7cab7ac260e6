"""Faults of the line: bytes that get lost, flipped, late; a stall, a reboot, a pulled cable.

Written NAME, NAME:AMOUNT or NAME:AMOUNT@SECONDS. The amount is a probability, a duration or a
speed; the seconds count samples since START, so that a seed repeats a fault exactly.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

#: name -> (default amount, what it is)
PER_BYTE = {
    "lost": (5e-4, "probability that a byte is lost"),
    "flipped": (5e-4, "probability that a bit of a byte is flipped"),
    "inserted": (5e-4, "probability that a byte is put in"),
    "duplicated": (5e-4, "probability that a byte comes twice"),
    "reordered": (5e-4, "probability that a byte changes places with the next"),
}
PER_FRAME = {
    "cut": (0.02, "probability that the end of a frame is missing"),
    "repeated": (0.02, "probability that a frame comes twice"),
    "missing": (0.02, "probability that a frame is lost"),
    "delayed": (0.02, "probability that the line holds still for 0.2 s before a frame"),
}
LASTING = {
    "slow": (600.0, "bytes a second that the line carries"),
    "held": (0.5, "seconds for which the line holds what came, and then delivers it at once"),
    "noise": (2e7, "bytes a second of noise, from a wrong baud rate or an open input"),
}
ONCE = {
    "stall": (3.0, "seconds of silence both ways"),
    "reboot": (0.5, "seconds until the rebooted board answers"),
    "unplug": (0.0, "no amount"),
    "stop-contact": (0.0, "no amount; the holder's contact opens"),
}
NAMES = (*PER_BYTE, *PER_FRAME, *LASTING, *ONCE)
DELAY_S = 0.2


@dataclass(frozen=True)
class Fault:
    """One fault; `at` is when it strikes (s sampled since START), for those that strike once."""

    name: str
    amount: float
    at: float = 0.0


def parse_fault(text: str, random: np.random.Generator, others: tuple[str, ...] = ()) -> Fault:
    """Return the fault of NAME[:AMOUNT][@SECONDS]; ValueError in words, with what else is known."""
    head, _, at = text.partition("@")
    name, _, amount = head.partition(":")
    known = PER_BYTE | PER_FRAME | LASTING | ONCE
    if name not in known:
        raise ValueError(f"no fault is called {name!r}; there are: {', '.join((*NAMES, *others))}")
    try:
        return Fault(
            name, float(amount) if amount else known[name][0], float(at) if at else random.uniform(4.5, 9.0)
        )
    except ValueError:
        raise ValueError(f"a fault is written NAME:AMOUNT@SECONDS with numbers, not {text!r}") from None


class Line:
    """What stands between the board's frames and the link. All times are the caller's clock, s."""

    def __init__(self, faults: tuple[Fault, ...], random: np.random.Generator) -> None:
        self._random = random
        self._odds = {f.name: f.amount for f in faults if f.name in PER_BYTE or f.name in PER_FRAME}
        self._rate = next((f.amount for f in faults if f.name == "slow"), None)
        self._held = next((f.amount for f in faults if f.name == "held"), 0.0)
        self._noise = next((f.amount for f in faults if f.name == "noise"), 0.0)
        self._heard = 0.0
        self._once = [f for f in faults if f.name in ONCE]
        self._queue: deque[tuple[float, bytes]] = deque()
        self._still_until = 0.0
        self._budget = 0.0
        self._counted = 0.0

    @property
    def waiting(self) -> int:
        """Bytes that have not left yet."""
        return sum(len(data) for _, data in self._queue)

    def strikes(self, sampled_s: float) -> Fault | None:
        """Return the next fault that strikes once and is due, and forget it."""
        for fault in self._once:
            if sampled_s >= fault.at > 0.0 and sampled_s > 0.0:
                self._once.remove(fault)
                return fault
        return None

    def hold(self, until: float) -> None:
        """Let nothing through before `until`."""
        self._still_until = max(self._still_until, until)

    def holds(self, now: float) -> bool:
        """Whether nothing gets through, in either direction."""
        return now < self._still_until

    def clear(self) -> None:
        """Forget what has not left yet."""
        self._queue.clear()

    def put(self, frame: bytes, now: float) -> None:
        """Take one frame of the board, spoil it, and queue it."""
        due = now
        if self._hit("missing"):
            return
        if self._hit("delayed"):
            due += DELAY_S
        if self._held:
            due = math.ceil(due / self._held) * self._held
        if self._queue:
            due = max(due, self._queue[-1][0])  # A serial line keeps the order.
        data = frame[: int(self._random.integers(1, len(frame)))] if self._hit("cut") else frame
        data = self._spoil(data)
        self._queue.append((due, data))
        if self._hit("repeated"):
            self._queue.append((due, data))

    def due(self, now: float) -> bytes:
        """Return the bytes that may leave now; what the link did not take is given `back`."""
        if self.holds(now):
            return b""
        out = b""
        while self._queue and self._queue[0][0] <= now:
            out += self._queue.popleft()[1]
        if self._noise:
            out += self._noisy(now)
        if self._rate is None:
            return out
        if self._counted:
            self._budget = min(self._rate * 0.1, self._budget + (now - self._counted) * self._rate)
        self._counted = now
        allowed = int(self._budget)
        self._budget -= min(allowed, len(out))
        self.back(out[allowed:], now)
        return out[:allowed]

    def _noisy(self, now: float) -> bytes:
        """Return the noise since it was asked for last, of at most 10 ms."""
        passed, self._heard = min(now - self._heard, 0.01), now
        return self._random.bytes(int(passed * self._noise))

    def back(self, data: bytes, now: float) -> None:
        """Put bytes back at the head of the queue."""
        if data:
            self._queue.appendleft((now, data))

    def _hit(self, name: str) -> bool:
        return name in self._odds and bool(self._random.random() < self._odds[name])

    def _spoil(self, data: bytes) -> bytes:
        if not self._odds:
            return data
        out = bytearray()
        for byte in data:
            if self._hit("lost"):
                continue
            value = byte ^ (1 << int(self._random.integers(8))) if self._hit("flipped") else byte
            if self._hit("inserted"):
                out.append(int(self._random.integers(256)))
            out.append(value)
            if self._hit("duplicated"):
                out.append(value)
            if self._hit("reordered") and len(out) > 1:
                out[-1], out[-2] = out[-2], out[-1]
        return bytes(out)
