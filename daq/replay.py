"""A replay: a session's raw bytes through the same decoder as live, at any speed, to an observer."""

import time

from daq.capture_stream import CaptureObserver
from daq.decode import IMPORT, Assembly, Block, play
from daq.errors import OperatorError
from daq.raw_log import Kind, Record
from daq.recording import Recording
from daq.session import Session

LONGEST_PAUSE_S = 1.0


def replay(session: Session, observer: CaptureObserver, speed: float = 1.0) -> Recording:
    """Show `observer` what it would have seen live and return the recording, which does not depend on the speed.

    `speed` times as fast as it came (0: as fast as possible); imports, which came at once, are paced by
    their sample times. Pauses longer than 1 s are cut short. OperatorError for a negative speed.
    """
    if not 0 <= speed < float("inf"):
        raise OperatorError(f"the speed must be 0 or more, not {speed:g}")
    assembly, described = Assembly(), False
    before: float | None = None
    for record, events in play(session.records(), assembly):
        if record.kind is Kind.NOTE:
            _note(assembly, observer, record)
        if not described and assembly.hello is not None and assembly.description is not None:
            described = True
            observer.connected(assembly.hello, assembly.channels)
        for event in events:
            if isinstance(event, Block):
                moment = event.first / assembly.rate if assembly.origin == IMPORT else record.time
                if speed > 0 and before is not None and moment > before:
                    time.sleep(min((moment - before) / speed, LONGEST_PAUSE_S))
                before = moment
                observer.block(event.first, event.samples)
            else:
                observer.loss(event)
    observer.state("sealed", f"{session.info.verdict or session.info.state.value}: {session.folder}")
    return session.complete(assembly.recording())


def _note(assembly: Assembly, observer: CaptureObserver, record: Record) -> None:
    note = record.note()
    if note.get("event") == "start":
        observer.state("armed", "the board samples")
    if note.get("event") == "window" and assembly.window is not None:
        trigger = assembly.window.trigger
        if trigger is not None and assembly.rate:
            observer.state("triggered", f"released at {trigger / assembly.rate:.3f} s")
        observer.state("recording", f"{assembly.window.count} samples")
