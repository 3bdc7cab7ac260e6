"""A rig that releases itself: its board holds the mass at a displacement and lets go, on command."""

import time
from contextlib import suppress

from daq.errors import BoardError, OperatorError, StationError
from daq.link import WARN_S, Link
from firmware_protocol import NO_SAMPLE, HelloRequest, Hold, Holder, HolderReason, HolderState, Release, Stop

ASKED = 3
HOLD_FOR_S = 60.0
_WHY = {
    HolderReason.BOOT: "its board restarted",
    HolderReason.STOP: "it was told to stop",
    HolderReason.SILENCE: "it did not hear from this computer",
    HolderReason.CONTACT: "its stop contact was opened",
    HolderReason.FAULT: "its holder is stuck",
}


class Rig:
    """The holder of the board behind `link`, which has shaken hands.

    OperatorError when the board has none. Everything that moves is the board's to allow: it refuses what is beyond its
    limits, and lets go slowly when it is told to stop or does not hear from the host. `take` of the link keeps it
    hearing while the mass is held.
    """

    def __init__(self, link: Link) -> None:
        self._link = link
        self._fresh()

    @property
    def report(self) -> Holder:
        """What the board last said of its holder."""
        report = self._link.assembly.holder
        assert report is not None
        return report

    def require(self, displacement: float) -> None:
        """OperatorError for a displacement (m) beyond the limits."""
        low, high = self.report.low, self.report.high
        if not low <= displacement <= high:
            raise OperatorError(
                f"{1e3 * displacement:g} mm is outside the range of this rig, {1e3 * low:g} to {1e3 * high:g} mm;"
                " nothing was moved"
            )

    def hold(self, displacement: float) -> None:
        """Take the mass, at rest, to a displacement (m) and return once it is held there.

        OperatorError beyond the limits, BoardError on NACK, or when the rig lets go on the way or does not arrive
        in time: then it is told to stop.
        """
        self.require(displacement)
        ticket = self._fresh().ticket
        self._link.keep_alive = True
        self._link.request(Hold(ticket, displacement))
        until = time.monotonic() + HOLD_FOR_S
        while (state := self.report.state) is not HolderState.HELD:
            self._require(state is HolderState.MOVING or self.report.ticket == ticket)
            if time.monotonic() > until:
                self.stop()
                raise BoardError(
                    f"the rig did not arrive at {1e3 * displacement:g} mm within {HOLD_FOR_S:g} s and was told to stop;"
                    " nothing was released. Check what blocks it"
                )
            if self._link.wait(lambda message: isinstance(message, Holder), WARN_S) is None:
                self._link.send(HelloRequest())  # a board that booted on the way only tells when it is asked

    def release(self) -> int | None:
        """Let go of the held mass; return the first sample taken after it, None when the board does not sample.

        BoardError when the rig holds nothing any more, or on NACK.
        """
        self._require(self.report.state is HolderState.HELD)
        self._link.request(Release(self.report.ticket))
        self._link.wait(lambda message: self.report.state is HolderState.FREE, WARN_S)
        self._link.keep_alive = False
        return None if self.report.sample == NO_SAMPLE else self.report.sample

    def stop(self) -> None:
        """Stop: the board ends sampling and lets go slowly. Sent once, without waiting; a dead line stops it too."""
        self._link.keep_alive = False
        with suppress(StationError):
            self._link.send(Stop())

    def _require(self, holds: bool) -> None:
        if not holds:
            why = _WHY.get(self.report.reason, "for a reason that this station does not know")
            self._link.keep_alive = False
            raise BoardError(f"the rig let go slowly before the release: {why}; nothing was released")

    def _fresh(self) -> Holder:
        """Ask for the newest ticket."""
        for _ in range(ASKED):
            self._link.send(HelloRequest(), prefix=b"\0")
            if self._link.wait(lambda message: isinstance(message, Holder), WARN_S) is not None:
                return self.report
        hello = self._link.assembly.hello
        board = hello.board if hello is not None and hello.board else "the board"
        raise OperatorError(
            f"{self._link.port.name}: {board} has no holder, so this rig cannot release itself; leave the displacement"
            " out and release the mass by hand"
        )
