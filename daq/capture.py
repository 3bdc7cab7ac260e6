"""A capture, from a port to a sealed session: rest, arm, trigger, record, ask again for what was lost, seal.

Everything that arrives is in the raw log before anything here looks at it, so whatever ends the story early
(a stall, an unplugged board, Ctrl-C, a full disk) leaves what was received.
"""

import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from daq.capture_settings import CaptureSettings
from daq.decode import Block
from daq.description_checks import Window
from daq.errors import DataLost, NoRelease, ProtocolError, Rebooted, Stalled, StationError
from daq.failover import FallbackFolder, SessionWriter
from daq.link import GIVE_UP_S, WARN_S, Link
from daq.observer import CaptureObserver
from daq.port import Port, open_port
from daq.quality import summary
from daq.raw_log import RawLog
from daq.recording import Gap
from daq.rest_detection import RestPeriod
from daq.session import Session
from daq.session_info import BoardInfo, SensorInfo, SessionInfo, State
from daq.trigger import Trigger
from firmware_protocol import HelloRequest, OtherVersion

__all__ = ["CaptureObserver", "CaptureSettings", "capture"]

RESEND_ROUNDS = 3
SPARE_BYTES = 1 << 20


def capture(
    port: str | Port,
    settings: CaptureSettings,
    folder: Path,
    observer: CaptureObserver | None = None,
    elsewhere: FallbackFolder | None = None,
) -> Session:
    """Capture one release from the board at `port` into the new session `folder`, and return it sealed.

    When the disk fails, the capture goes on in memory and `elsewhere` is asked for another folder (None
    gives up). Without `elsewhere` a disk that fails before the capture raises, and one that fails during
    it means a new folder among the system's temporary files: see `folder` of what is returned.

    Raises a StationError of `daq.errors` by whose fault it is; what was received is kept in its `session`.
    KeyboardInterrupt leaves an aborted session. Every wait is bounded.
    """
    opened = open_port(port) if isinstance(port, str) else port
    log = RawLog()
    with Link(opened, log) as link:
        link.handshake()
        link.configure(settings.rate_hz)
        story = _Capture(link, settings, observer or CaptureObserver())
        info = story.describe()
        keeper = SessionWriter.begin(folder, info, log, elsewhere, story.space())
        try:
            story.run()
        except BaseException as error:
            story.give_up(keeper, error)
            raise
        return story.seal(keeper)


class _Capture:
    """The steps of one capture; each returns when the next may begin."""

    def __init__(self, link: Link, settings: CaptureSettings, observer: CaptureObserver) -> None:
        self.link = link
        self.settings = settings
        self.observer = observer
        self.resent = 0
        self.noise: dict[str, float] = {}
        self.rate = link.assembly.rate
        self.channels = link.assembly.channels
        self._name = "resting"
        self._warned = 0
        self._last_block = time.monotonic()
        self._early: int | None = None
        self._blocks: list[Block] = []
        link.on_happening = self._happened

    @property
    def planned(self) -> int:
        return round(self.settings.pre_trigger_s * self.rate) + round(self.settings.duration_s * self.rate)

    def space(self) -> int:
        """Bytes that the session may need: twice what the samples take in their widest format."""
        per_second = self.rate * len(self.channels) * 8 * 2
        settings = self.settings
        seconds = settings.rest_s + settings.pre_trigger_s + settings.trigger_timeout_s + settings.duration_s
        return SPARE_BYTES + round(per_second * seconds)

    def describe(self) -> SessionInfo:
        """Tell the observer who answered and return the session's metadata."""
        hello = self.link.assembly.hello
        assert hello is not None
        self.observer.connected(hello, self.channels)
        info = self.settings.info
        known = {sensor.channel: sensor for sensor in info.sensors}
        sensors = tuple(
            known.pop(c.name, SensorInfo(channel=c.name, sensor=c.sensor)) for c in self.channels
        ) + tuple(known.values())
        board = BoardInfo(
            board=hello.board,
            firmware=hello.firmware,
            unique_id=hello.unique_id,
            boot_id=hello.boot_id,
            protocol=f"{hello.major}.{hello.minor}",
        )
        changes = {
            "state": State.RECORDING,
            "sensors": sensors,
            "source": info.source or self.link.port.name,
            "board": board,
            "rate_hz": self.rate,
            "planned_samples": self.planned,
        }
        return info.model_copy(update=changes)

    def run(self) -> None:
        """From START to the last sample that can be had."""
        self.link.start()
        self._last_block = time.monotonic()
        trigger = self._rest()
        release = self._wait_for_release(trigger) if self.settings.wait_for_release else self._now()
        self._record(release)
        self.link.stop()
        self._ask_again()

    def _rest(self) -> Trigger:
        """Wait until the mass is still; a release before the rest is complete is not missed."""
        settings = self.settings
        self._state("resting", f"measuring the noise; keep the mass still for {settings.rest_s:g} s")
        period = RestPeriod(self.channels, self.rate, settings.rest_s, settings.trigger_level)
        until = _Until(self, settings.rest_timeout_s)
        trigger: Trigger | None = None
        for block in self._arriving(until):
            period.feed(block.samples)
            if period.rest is not None and trigger is None:
                trigger = Trigger(self.channels, self.rate, period.rest, settings.trigger_level)
            if trigger is not None and period.rest is not None:
                self._early = self._triggered(trigger, block)
                if period.complete or self._early is not None:
                    trigger.set_rest(period.rest)
                    self._note_noise(trigger)
                    return trigger
        raise NoRelease(
            f"the mass did not come to rest within {settings.rest_timeout_s:g} s; hold it still, or give a"
            " larger trigger level"
        )

    def _note_noise(self, trigger: Trigger) -> None:
        noise = trigger.rest.noise.tolist()
        self.noise = {c.name: value for c, value in zip(self.channels, noise, strict=True)}

    def _wait_for_release(self, trigger: Trigger) -> int:
        settings = self.settings
        if self._early is not None:
            return self._early
        noise = ", ".join(f"{c.name} {self.noise[c.name]:.2g} {c.unit}" for c in self.channels)
        self._state("armed", f"release the mass; noise at rest: {noise}")
        for block in self._arriving(_Until(self, settings.trigger_timeout_s)):
            release = self._triggered(trigger, block)
            if release is not None:
                return release
        raise NoRelease(
            f"no release within {settings.trigger_timeout_s:g} s; what was received is kept. Release the"
            " mass after arming, or give a smaller trigger level"
        )

    def _now(self) -> int:
        return self._early if self._early is not None else self.link.assembly.expected

    def _triggered(self, trigger: Trigger, block: Block) -> int | None:
        found = trigger.feed(block.first, block.samples)
        if found is None:
            return None
        self._state(
            "triggered",
            f"released at {found.sample / self.rate:.3f} s, seen by {found.channel};"
            f" {0.5 / found.half_period_s:.3g} Hz",
        )
        return found.sample

    def _record(self, release: int) -> None:
        """Record until the duration after the release is over."""
        settings = self.settings
        first = max(release - round(settings.pre_trigger_s * self.rate), 0)
        stop = release + round(settings.duration_s * self.rate)
        window = Window(first, stop - first, release if settings.wait_for_release else None)
        self.link.log.note(event="window", first=first, count=stop - first, trigger=window.trigger)
        self.link.assembly.window = window
        self._state("recording", f"{settings.duration_s:g} s from the release on")
        until = _Until(self, 2 * settings.duration_s + 5, by_samples=False)
        while self.link.assembly.expected < stop and not until.over():
            self._next_blocks()

    def _ask_again(self) -> None:
        """Ask for samples that the wire lost, three times at most."""
        for _ in range(RESEND_ROUNDS):
            lost = [gap for gap in self.link.assembly.missing() if gap.reason == "wire"]
            if not lost:
                return
            self._state("resending", f"asking again for {sum(g.count for g in lost)} samples")
            before = self._lost()
            held = [self.link.resend(gap.first, gap.count) for gap in lost]
            self.resent += before - self._lost()
            if not any(held) and before == self._lost():
                return

    def _lost(self) -> int:
        return sum(gap.count for gap in self.link.assembly.missing())

    def _arriving(self, until: "_Until") -> Iterator[Block]:
        """Yield blocks as they come until the time is over."""
        while not until.over():
            yield from self._next_blocks()

    def _next_blocks(self) -> list[Block]:
        """Take what arrives next; raise when the board is silent, gone, new or contradicts itself."""
        self._blocks = []
        frame = self.link.take(0.05)
        if frame is not None and isinstance(frame.message, OtherVersion):
            raise ProtocolError("the board changed its protocol version in mid-capture; reset it")
        if self.link.assembly.contradictions:
            what = self.link.assembly.contradictions[-1]
            raise ProtocolError(f"{what}; what was received is kept, its firmware needs a correction")
        if self.link.assembly.rebooted:
            raise Rebooted("the board rebooted in mid-capture; what came before is kept. Check its supply")
        self._watch_silence()
        return self._blocks

    def _watch_silence(self) -> None:
        """A silent board is told at 0.5 s and given up at 2 s; so is one that talks but sends no samples."""
        silence = time.monotonic() - self._last_block - 2 / self.rate
        if silence < WARN_S:
            self._warned = 0
            return
        if silence > GIVE_UP_S:
            raise Stalled(self._silent())
        if not self._warned:
            self.observer.state(self._name, f"nothing came for {WARN_S:g} s")
        if silence > WARN_S * (self._warned + 1):
            self._warned += 1
            self.link.send(HelloRequest(), prefix=b"\0")

    def _silent(self) -> str:
        kept = "what was received is kept"
        if self.link.silence() > WARN_S:
            return (
                f"the board has been silent for {GIVE_UP_S:g} s; {kept}. Check cable and board, or reset it"
            )
        clock = self.link.assembly.host_clock()
        if clock is not None and clock.rate < 0.9 * self.rate:
            return (
                f"only {clock.rate:.0f} of {self.rate:g} samples per second came, then none for"
                f" {GIVE_UP_S:g} s; {kept}. The line is too slow for this rate"
            )
        return f"the board talks but sent no samples for {GIVE_UP_S:g} s; {kept}. Reset it"

    def _happened(self, happening: Block | Gap) -> None:
        if isinstance(happening, Gap):
            self.observer.loss(happening)
            return
        self._last_block = time.monotonic()
        self._blocks.append(happening)
        self.observer.block(happening.first, happening.samples)

    def _state(self, name: str, detail: str) -> None:
        self._name = name
        self.observer.state(name, detail)

    def give_up(self, keeper: SessionWriter, error: BaseException) -> None:
        """Keep what was received; the error carries the folder."""
        reason = str(error) or ("interrupted" if isinstance(error, KeyboardInterrupt) else repr(error))
        try:
            session = self._finish(keeper, State.ABORTED, reason)
        except StationError as worse:
            raise worse from error
        if isinstance(error, StationError):
            error.session = session.folder

    def seal(self, keeper: SessionWriter) -> Session:
        """Seal the session; DataLost when more stayed lost than the settings allow."""
        session = self._finish(keeper, State.SEALED, "")
        self._state("sealed", f"{session.info.verdict}: {session.folder}")
        gaps = self.link.assembly.missing()
        lost, planned = sum(gap.count for gap in gaps), max(self.planned, 1)
        if lost > self.settings.lost_limit * planned:
            raise DataLost(
                f"{lost} of {planned} samples stayed lost ({summary(gaps)}), more than"
                f" {self.settings.lost_limit:.3g} of them; the session is kept",
                session.folder,
            )
        return session

    def _finish(self, keeper: SessionWriter, state: State, reason: str) -> Session:
        return keeper.finish(
            state,
            reason,
            changes={"noise": self.noise, "rate_std_hz": self._rate_std()},
            resent=self.resent,
            damaged_frames=self.link.statistics.damaged,
            check_clock=self.settings.check_clock,
        )

    def _rate_std(self) -> float | None:
        """The board's rate against the host's clock; None when the two do not keep the same time."""
        clock = self.link.assembly.host_clock()
        if clock is None or not np.isfinite(clock.std) or abs(clock.rate / self.rate - 1) > 0.005:
            return None
        return max(clock.std, abs(clock.rate - self.rate))


class _Until:
    """A time limit by the host's clock and by the board's samples, whichever is over first."""

    def __init__(self, story: _Capture, seconds: float, by_samples: bool = True) -> None:
        self._assembly = story.link.assembly
        self._time = time.monotonic() + seconds
        self._sample = self._assembly.expected + seconds * story.rate if by_samples else float("inf")

    def over(self) -> bool:
        """Tell whether the limit is reached."""
        return time.monotonic() > self._time or self._assembly.expected > self._sample
