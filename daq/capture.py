"""A capture, from a port to a sealed session: rest, arm, trigger, record, ask again for what was lost, seal.

Everything that arrives is in the raw log before anything here looks at it, so whatever ends a capture early
(a stall, an unplugged board, Ctrl-C, a full disk) leaves what was received.
"""

import time
from dataclasses import asdict
from functools import partial
from pathlib import Path

from daq.capture_settings import CaptureSettings as CaptureSettings
from daq.capture_stream import CaptureObserver as CaptureObserver, CaptureStream
from daq.decode import Block
from daq.description_checks import Window
from daq.errors import DataLost, OperatorError, StationError
from daq.failover import FallbackFolder, SessionWriter
from daq.link import Link
from daq.port import Port, open_port
from daq.quality import lost_outside, summary
from daq.raw_log import Kind, RawLog
from daq.rig import Rig
from daq.session import Session
from daq.session_info import BoardInfo, SensorInfo, SessionInfo, State
from daq.sources.source_board import SourceBoard
from daq.trigger import RestPeriod, Trigger

RESEND_ROUNDS = 3
RESEND_FOR_S = 30.0
MICROMETRES = 1e-4
"""Noise of a length (m) below which it is written in um."""


def capture(
    port: str | Port,
    settings: CaptureSettings,
    folder: Path,
    observer: CaptureObserver | None = None,
    fallback: FallbackFolder | None = None,
) -> Session:
    """Capture one release from the board at `port` into the new session `folder`, and return it sealed.

    When the disk fails, the capture goes on in memory and `fallback` is asked for another folder (None
    gives up). Without `fallback` a disk that fails before the capture raises, and one that fails during
    it means a new folder among the system's temporary files: see `folder` of what is returned.

    Raises a StationError of `daq.errors` by whose fault it is; what was received is kept in its `session`.
    KeyboardInterrupt leaves an aborted session. Every wait is bounded.
    """
    opened = open_port(port) if isinstance(port, str) else port
    log = RawLog()
    if isinstance(opened, SourceBoard):
        opened.keep = partial(log.append, Kind.SOURCE)
        log.note(event="source")  # its times are those of its text, not of a timer that samples
    with Link(opened, log) as link:
        link.handshake()
        rig = None
        if settings.release_from is not None:
            rig = Rig(link)
            rig.require(settings.release_from)
        link.configure(settings.rate_hz)
        run = _Capture(link, settings, observer or CaptureObserver(), rig)
        link.allow(settings.log_bytes(*run.load))
        writer = SessionWriter.begin(folder, run.describe(), log, fallback, settings.disk_bytes(*run.load))
        try:
            run.record()
        except BaseException as error:
            if rig is not None:
                rig.stop()
            run.abort(writer, error)
            raise
        return run.seal(writer)


class _Capture:
    """The steps of one capture; each returns when the next may begin."""

    def __init__(
        self, link: Link, settings: CaptureSettings, observer: CaptureObserver, rig: Rig | None
    ) -> None:
        self._link = link
        self._rig = rig
        self._settings = settings
        self._observer = observer
        self._stream = CaptureStream(link, observer)
        self._rate = link.assembly.rate
        self._channels = link.assembly.channels
        self._noise: dict[str, float] = {}
        self._early: int | None = None
        self._resent = 0

    @property
    def _planned(self) -> int:
        settings = self._settings
        return round(settings.pre_trigger_s * self._rate) + round(settings.duration_s * self._rate)

    @property
    def load(self) -> tuple[float, int]:
        """Samples per second, and the bytes of each, all channels together."""
        description = self._link.assembly.description
        assert description is not None
        return self._rate, len(self._channels) * description.format.size

    def describe(self) -> SessionInfo:
        """Say to the observer who answered and return the session's metadata."""
        hello = self._link.assembly.hello
        assert hello is not None
        self._observer.connected(hello, self._channels)
        info = self._settings.info
        known = {sensor.channel: sensor for sensor in info.sensors}
        sensors = tuple(
            known.pop(c.name, SensorInfo(channel=c.name, sensor=c.sensor)) for c in self._channels
        ) + tuple(known.values())
        board = BoardInfo.model_validate({**asdict(hello), "protocol": f"{hello.major}.{hello.minor}"})
        changes = {
            "state": State.RECORDING,
            "sensors": sensors,
            "source": info.source or self._link.port.name,
            "board": board,
            "rate_hz": self._rate,
            "planned_samples": self._planned,
        }
        return info.model_copy(update=changes)

    def record(self) -> None:
        """From START to the last sample that can be had."""
        self._stream.start()
        trigger = self._rest()
        if self._rig is not None:
            trigger = self._hold(self._rig)
        release = self._early
        if release is None:
            waits = self._settings.wait_for_release
            release = self._wait_for_release(trigger) if waits else self._link.assembly.expected
        self._take_window(release)
        self._link.stop()
        self._ask_again()

    def _hold(self, rig: Rig) -> Trigger:
        """Let the rig take the mass to its displacement, wait until it is still there, and let go."""
        place = self._settings.release_from
        assert place is not None
        if self._early is not None:
            raise OperatorError(
                "the mass swung before the rig held it; nothing was moved. Let it come to rest first"
            )
        self._stream.state("holding", f"the rig takes the mass to {1e3 * place:g} mm")
        rig.hold(place)
        self._stream.skip()
        trigger = self._rest()
        rig.release()
        return trigger

    def _rest(self) -> Trigger:
        """Wait until the mass is still; a release before the rest is complete is not missed."""
        settings = self._settings
        detail = f"measuring the noise; keep the mass still for {settings.rest_s:g} s"
        began = time.monotonic()
        self._stream.state("resting", detail)
        period = RestPeriod(self._channels, self._rate, settings.rest_s, settings.trigger_level)
        trigger: Trigger | None = None
        for block in self._stream.during(settings.rest_timeout_s):
            period.feed(block.samples)
            if period.noise is None:
                continue
            if trigger is None:
                history = self._link.assembly.between
                trigger = Trigger(self._channels, self._rate, period.noise, history, settings.trigger_level)
            self._early = self._triggered(trigger, block)
            if period.complete or self._early is not None:
                trigger.noise = period.noise
                self._noise = dict(zip((c.name for c in self._channels), period.noise.tolist(), strict=True))
                return trigger
        raise OperatorError(
            f"the mass did not come to rest within {_waited(settings.rest_timeout_s, began)}; hold it still, or"
            " give a larger trigger level"
        )

    def _wait_for_release(self, trigger: Trigger) -> int:
        settings = self._settings
        noise = ", ".join(f"{c.name} {_small(self._noise[c.name], c.unit)}" for c in self._channels)
        whose = "release the mass" if self._rig is None else "the rig has released the mass"
        self._stream.state("armed", f"{whose}; noise at rest: {noise}")
        began = time.monotonic()
        for block in self._stream.during(settings.trigger_timeout_s):
            release = self._triggered(trigger, block)
            if release is not None:
                return release
        waited = _waited(settings.trigger_timeout_s, began)
        if self._rig is not None:
            raise OperatorError(
                f"the rig let go, and no swing came within {waited}; what was received is kept. See whether its magnet"
                " grips, or give a smaller trigger level"
            )
        raise OperatorError(
            f"no release within {waited}; what was received is kept. Release the mass after arming, or give a smaller"
            " trigger level"
        )

    def _triggered(self, trigger: Trigger, block: Block) -> int | None:
        found = trigger.feed(block.first, block.samples)
        if found is None:
            return None
        self._stream.state(
            "triggered",
            f"released at {found.sample / self._rate:.3f} s, seen by {found.channel};"
            f" {0.5 / found.half_period_s:.3g} Hz",
        )
        return found.sample

    def _take_window(self, release: int) -> None:
        """Record until the duration after the release is over."""
        settings = self._settings
        first = max(release - round(settings.pre_trigger_s * self._rate), 0)
        stop = release + round(settings.duration_s * self._rate)
        window = Window(first, stop - first, release if settings.wait_for_release else None)
        self._link.log.note(event="window", first=first, count=stop - first, trigger=window.trigger)
        self._link.assembly.window = window
        self._stream.state("recording", f"{settings.duration_s:g} s from the release on")
        self._stream.take_to(stop, 2 * settings.duration_s + 5)

    def _ask_again(self) -> None:
        """Ask for samples that the wire lost, and for those that the checksum needs beside them.

        Ends when three rounds in a row bring nothing, or after `RESEND_FOR_S`. A board that no longer holds what the
        checksum needs, or leaves three requests in a row unanswered, is asked no further.
        """
        assembly, until = self._link.assembly, time.monotonic() + RESEND_FOR_S
        unanswered, checkable, in_vain = 0, True, 0
        while in_vain < RESEND_ROUNDS:
            lost = [(gap.first, gap.count) for gap in assembly.missing() if gap.reason == "wire"]
            holes = [*lost, *(lost_outside(assembly) if checkable else [])]
            if not holes:
                return
            self._stream.state("resending", f"asking again for {sum(n for _, n in holes)} samples")
            refused = brought = 0
            for hole in holes:
                if unanswered >= RESEND_ROUNDS or time.monotonic() >= until:
                    return
                before = assembly.samples.received
                held = self._link.resend(*hole, until)
                came = assembly.samples.received - before
                unanswered = 0 if came or held is not None else unanswered + 1
                refused += held is False
                brought += came
                self._resent += came
            checkable = not refused
            in_vain = 0 if brought else in_vain + 1
            if refused == len(holes):
                return

    def abort(self, writer: SessionWriter, error: BaseException) -> None:
        """Keep what was received as an aborted session; its folder is noted in the error."""
        reason = str(error) or ("interrupted" if isinstance(error, KeyboardInterrupt) else repr(error))
        try:
            session = self._finish(writer, State.ABORTED, reason)
        except StationError as worse:
            raise worse from error
        if isinstance(error, StationError | KeyboardInterrupt):
            error.session = session.folder  # type: ignore[union-attr]

    def seal(self, writer: SessionWriter) -> Session:
        """Seal the session; DataLost when more stayed lost than the settings allow."""
        session = self._finish(writer, State.SEALED, "")
        self._stream.state("sealed", f"{session.info.verdict}: {session.folder}")
        gaps = self._link.assembly.missing()
        lost, planned = sum(gap.count for gap in gaps), max(self._planned, 1)
        if lost > self._settings.lost_limit * planned:
            raise DataLost(
                f"{lost} of {planned} samples stayed lost ({summary(gaps)}), more than"
                f" {self._settings.lost_limit:.3g} of them; the session is kept",
                session.folder,
            )
        return session

    def _finish(self, writer: SessionWriter, state: State, reason: str) -> Session:
        return writer.finish(
            state,
            reason,
            changes={"noise": self._noise},
            resent=self._resent,
            damaged_frames=self._link.statistics.damaged,
            check_clock=self._settings.check_clock,
        )


def _small(value: float, unit: str) -> str:
    """Return a noise with its unit, lengths in um."""
    return f"{1e6 * value:.2g} um" if unit == "m" and value < MICROMETRES else f"{value:.2g} {unit}"


def _waited(seconds: float, began: float) -> str:
    """Write the waiting time, and its clock: the board may count its seconds faster than this computer."""
    here = time.monotonic() - began
    if here > 0.8 * seconds:
        return f"{seconds:g} s"
    return f"{seconds:g} s by the board's samples, {here:.2g} s by this computer's clock"
