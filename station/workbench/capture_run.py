"""One capture under way: in a thread of its own, watched by every tab, and ended on request."""

import threading
import time
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from daq.capture import CaptureObserver, CaptureSettings, capture
from daq.errors import StationError
from daq.quality import Verdict
from daq.recording import Array, Channel, Gap
from firmware_protocol import Hello
from station.exits import Problem
from station.operations.new_session import new_folder
from station.text.capture_progress import STATES
from station.text.numbers import scale_as_recorded
from station.workbench.scope import Scope, ScopeTrace
from station.workbench.stored_sessions import describe, rename


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

    `finished` says that it has ended: with a `session` (its folder), or with a `problem` in a sentence; `kept` is
    what was received of a capture that failed.
    """

    state: str = ""
    sentence: str = "asking the board"
    detail: str = ""
    levels: tuple[Level, ...] = ()
    lost: int = 0
    recorded: float = 0.0
    finished: bool = False
    problem: str = ""
    verdict: Verdict | None = None
    session: Path | None = None
    kept: Path | None = None
    scope: Scope = field(default_factory=Scope)


class CaptureRun(CaptureObserver):
    """A capture that runs until it is sealed, fails, or is cancelled.

    `written` is what the operator writes beside the scope, by its name in the session, and the session's `name`.
    """

    def __init__(
        self,
        board: AbstractContextManager[str],
        settings: CaptureSettings,
        sessions: Path,
        prefix: str = "release",
    ) -> None:
        self.now = Progress()
        self.written: dict[str, Any] = {}
        self._board, self._settings = board, settings
        plain = sessions / prefix
        self._folder = plain if prefix != "release" and not plain.exists() else new_folder(sessions, prefix)
        self._trace = ScopeTrace(settings)
        self._channels: tuple[Channel, ...] = ()
        self._largest = np.zeros(0)
        self._recording_since = 0.0
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="capture", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """End the capture; what was received is kept."""
        self._ended = True

    def wait(self, seconds: float) -> None:
        """Wait until it has ended, at most some seconds."""
        self._thread.join(seconds)

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Note the channels."""
        self._go_on()
        self._channels = channels
        self._largest = np.full(len(channels), 1e-300)
        self._trace.connected(channels)

    def state(self, name: str, detail: str) -> None:
        """Note where it stands."""
        if name != "sealed":
            self._go_on()
        if name == "recording" and self.now.state != name:
            self._recording_since = time.monotonic()
        self._trace.state(name)
        self.now = replace(self.now, state=name, sentence=STATES.get(name, name), detail=detail)

    def block(self, first_index: int, samples: Array) -> None:
        """Note the levels."""
        self._go_on()
        if not samples.shape[1]:
            return
        self._trace.block(samples)
        self._largest = np.maximum(self._largest, np.abs(samples).max(axis=1))
        levels = []
        for channel, value, largest in zip(self._channels, samples[:, -1], self._largest, strict=True):
            factor, unit = scale_as_recorded(channel.quantity, channel.unit)
            levels.append(Level(channel.name, float(value) * factor, unit, float(value / largest)))
        seconds = time.monotonic() - self._recording_since
        share = min(seconds / self._settings.duration_s, 1.0) if self.now.state == "recording" else 0.0
        self.now = replace(self.now, levels=tuple(levels), recorded=share, scope=self._trace.scope())

    def loss(self, gap: Gap) -> None:
        """Note a loss."""
        self._go_on()
        self.now = replace(self.now, lost=self.now.lost + gap.count)

    def _go_on(self) -> None:
        """Leave the capture the way Ctrl-C does, so that the session is closed as aborted."""
        if self._ended:
            raise KeyboardInterrupt("cancelled on the workbench")

    def _run(self) -> None:
        found: dict[str, Any] = {}
        try:
            with self._board as port:
                session = capture(port, self._settings, self._folder, self)
            found = {"session": session.folder, "verdict": session.verdict}
            found["session"] = self._described(session.folder)
        except KeyboardInterrupt:
            found = {"problem": "cancelled", "kept": self._folder if self._folder.is_dir() else None}
        except StationError as error:
            found = {"problem": str(error), "kept": error.session}
        except Problem as error:
            found["problem"] = str(error)
        except Exception as error:
            found["problem"] = f"a fault of this program ({type(error).__name__}: {error})"
        self.now = replace(self.now, finished=True, **found)

    def _described(self, folder: Path) -> Path:
        """Write what was filled in beside the scope into the session; return its folder, renamed where a name was given."""
        known = {key: value for key, value in self.written.items() if value is not None}
        name = known.pop("name", "")
        if known:
            describe(folder, **known)
        return rename(folder, name) if name else folder
