"""A board that prints a simulated release, a line a sample, as fast as it is read."""

import numpy as np

from mocks.generate import draw

RATE = 256.0


def release(rest_s: float = 6.0, seed: int = 5):
    """Return displacement (m) and acceleration (m/s^2), (n,) each: the mass at rest, then let go; and the truth."""
    x = draw(None, 0.0, seed)
    rest = int(rest_s * RATE)
    random = np.random.default_rng(seed)
    still = [(values[:150].mean(), values[:150].std()) for values in (x.displacement, x.acceleration)]
    motion = [
        np.concatenate([random.normal(mean, std, rest), values[100:]])
        for (mean, std), values in zip(still, (x.displacement, x.acceleration), strict=True)
    ]
    return motion[0], motion[1], x


class PrintingBoard:
    """A port whose bytes are lines; `at_once` lines come with each read, `lose` are never sent."""

    name = "printing board"

    def __init__(self, lines, at_once: int = 40, header: str = "", lose=()) -> None:
        self._lines = [header] * bool(header) + [line for i, line in enumerate(lines) if i not in set(lose)]
        self._at = 0
        self._at_once = at_once
        self.closed = False

    def read(self) -> bytes:
        part = self._lines[self._at : self._at + self._at_once]
        self._at += len(part)
        return "".join(f"{line}\r\n" for line in part).encode()

    def write(self, data: bytes) -> None:
        raise AssertionError("a board that prints takes nothing")

    def close(self) -> None:
        self.closed = True


def as_csv(displacement, acceleration):
    """Return lines of whole milliseconds, micrometres and m/s^2."""
    return [
        f"{int(1000 * i / RATE)},{1e6 * d:.2f},{a:.6f}"
        for i, (d, a) in enumerate(zip(displacement, acceleration, strict=True))
    ]


def as_json(displacement, acceleration):
    """Return JSON lines with a counter of 8 bits."""
    return [
        f'{{"n": {i % 256}, "x": {1e3 * d:.6f}, "imu": [0, {a:.6f}]}}'
        for i, (d, a) in enumerate(zip(displacement, acceleration, strict=True))
    ]
