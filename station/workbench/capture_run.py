"""One capture under way: in a thread of its own, watched by every tab with its live scope, and ended on request."""

import secrets
import threading
import time
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.recording import Array, Channel, Gap
from daq.session import Session
from daq.trigger import primary, threshold
from firmware_protocol import Hello
from station.exits import sentence_of
from station.operations.mystery import BOARD, SEEDS
from station.operations.simulated_board import simulated_board, simulated_capture
from station.settings import Settings
from station.text.capture_progress import STATES
from station.text.numbers import scale_as_recorded, typeset

MYSTERY_SPEED = 2.0
SHOWN_S = 8.0
POINTS = 300


@dataclass(frozen=True)
class Scope:
    """What the scope draws: pairs of (time in s, value) in `unit`, oldest first.

    `zero`, `noise` (standard deviation at rest) and `level` (the swing that counts as a release) are in `unit`, None
    while they are not known; `left_s` is how long the present state lasts at most.
    """

    channel: str = ""
    unit: str = ""
    points: tuple[tuple[float, float], ...] = ()
    zero: float | None = None
    noise: float | None = None
    level: float | None = None
    left_s: float | None = None


@dataclass(frozen=True)
class Level:
    """The newest value of a channel in the unit that is shown, and how large it is against the largest so far."""

    channel: str
    value: float
    unit: str
    share: float


@dataclass(frozen=True)
class Progress:
    """Where a capture stands. `state` as the observer was given it, "" before the board has answered.

    `finished` says that it has ended, of a capture with the sealed `session`, or with a `problem` in a sentence.
    """

    state: str = ""
    sentence: str = "asking the board"
    detail: str = ""
    levels: tuple[Level, ...] = ()
    lost: int = 0
    finished: bool = False
    problem: str = ""
    session: Session | None = None
    scope: Scope = field(default_factory=Scope)

    @property
    def key(self) -> str:
        """The name of the session that the capture made; "" where it made none."""
        return "" if self.session is None else self.session.folder.name


class ScopeObserver(CaptureObserver):
    """Gathers what a capture shows: `now` is where it stands, with what the scope draws. It can end the capture."""

    def __init__(self, settings: CaptureSettings) -> None:
        self.now = Progress()
        self._settings = settings
        self._channels: tuple[Channel, ...] = ()
        self._largest = np.zeros(0)
        self._row, self._ended = 0, False
        self._since = time.monotonic()

    def cancel(self) -> None:
        """End the capture; what was received is kept."""
        self._ended = True

    def _go_on(self) -> None:
        """Leave the capture the way Ctrl-C does, so that the session is closed as aborted."""
        if self._ended:
            raise KeyboardInterrupt("cancelled on the workbench")

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Note the channels; the one that triggers is shown."""
        self._go_on()
        self._channels, self._largest = channels, np.full(len(channels), 1e-300)
        wanted = primary(channels)
        self._row = next((i for i, c in enumerate(channels) if c.quantity == wanted), 0)
        self._times, self._values, self._rest = np.zeros(0), np.zeros(0), np.zeros(0)
        self._last = time.monotonic()
        self.now = replace(self.now, lost=0)

    def state(self, name: str, detail: str) -> None:
        """Note where it stands."""
        if name != "sealed":
            self._go_on()
        if name != self.now.state:
            self._since = time.monotonic()
        self.now = replace(self.now, state=name, sentence=STATES.get(name, name), detail=typeset(detail))

    def block(self, first_index: int, samples: Array) -> None:
        """Keep samples, shape (channels, n), spread over the time since the block before; note the levels."""
        self._go_on()
        now, row = time.monotonic(), samples[self._row]
        if self.now.state == "resting":
            self._rest = np.append(self._rest, row)[-2000:]
        times = np.append(self._times, np.linspace(self._last, now, len(row) + 1)[1:])
        new = np.searchsorted(times, now - SHOWN_S)
        self._times, self._values, self._last = times[new:], np.append(self._values, row)[new:], now
        self._largest = np.maximum(self._largest, np.abs(samples).max(axis=1))
        levels = []
        for channel, value, largest in zip(self._channels, samples[:, -1], self._largest, strict=True):
            factor, unit = scale_as_recorded(channel.quantity, channel.unit)
            levels.append(Level(channel.name, float(value) * factor, unit, float(value / largest)))
        self.now = replace(self.now, levels=tuple(levels), scope=self._scope())

    def loss(self, gap: Gap) -> None:
        """Note a loss."""
        self._go_on()
        self.now = replace(self.now, lost=self.now.lost + gap.count)

    def _scope(self) -> Scope:
        """Choose the points to draw; extremes are kept where there are more samples than points."""
        channel = self._channels[self._row]
        factor, unit = scale_as_recorded(channel.quantity, channel.unit)
        zero = noise = level = None
        if len(self._rest) >= 8:
            scatter = float(np.std(self._rest))
            zero, noise = factor * float(np.median(self._rest)), factor * scatter
            level = factor * threshold(channel, scatter, self._settings.trigger_level)
        shown = _extremes(self._values)
        times, values = self._times[shown] - self._last, self._values[shown] * factor
        return Scope(
            channel.name,
            typeset(unit),
            tuple((round(t, 3), float(f"{y:.5g}")) for t, y in zip(times, values, strict=True)),
            zero=zero,
            noise=noise,
            level=level,
            left_s=self._left(),
        )

    def _left(self) -> float | None:
        lasts = {
            "resting": self._settings.rest_s,
            "armed": self._settings.trigger_timeout_s,
            "triggered": self._settings.duration_s,
            "recording": self._settings.duration_s,
        }.get(self.now.state)
        return None if lasts is None else max(0.0, lasts - (time.monotonic() - self._since))


def _extremes(values: Array) -> NDArray[np.intp]:
    """Choose samples in order: all where they are few, else the smallest and the largest of each part."""
    if len(values) < 2 * POINTS:
        return np.arange(len(values))
    parts = np.array_split(np.arange(len(values)), POINTS // 2)
    return np.unique([part[find(values[part])] for part in parts for find in (np.argmin, np.argmax)])


def mystery(settings: Settings, *more: str) -> tuple[int, AbstractContextManager[str], CaptureSettings]:
    """Draw a mystery: its number, a simulated board that hides something, given `more` options, and how it is captured."""
    seed = secrets.randbelow(SEEDS)
    board = simulated_board(seed, MYSTERY_SPEED, *more, module=BOARD)
    return seed, board, simulated_capture(settings, f"mystery {seed}", MYSTERY_SPEED)


class CaptureRun(ScopeObserver):
    """A capture into a new `folder` in a thread of its own, until it is sealed, fails, or is cancelled."""

    def __init__(self, board: AbstractContextManager[str], settings: CaptureSettings, folder: Path) -> None:
        super().__init__(settings)
        self.folder, self._board = folder, board
        self._thread = threading.Thread(target=self._run, name="capture", daemon=True)
        self._thread.start()

    def wait(self, seconds: float) -> None:
        """Wait until it has ended, at most some seconds."""
        self._thread.join(seconds)

    def _run(self) -> None:
        session, problem = None, ""
        try:
            with self._board as port:
                session = self._record(port)
        except KeyboardInterrupt:
            problem = "cancelled"
        except Exception as error:
            problem = sentence_of(error)
        self.now = replace(self.now, finished=True, session=session, problem=problem)

    def _record(self, port: str) -> Session | None:
        return capture(port, self._settings, self.folder, self)
