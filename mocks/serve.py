"""The loop that joins board, line and link, until it is asked to end."""

from __future__ import annotations

import time
from collections.abc import Callable

from mocks.board import Board
from mocks.faults import Fault, Line
from mocks.link import Link

TICK_S = 0.005
#: While this many bytes wait on the way out the board gets no room to send samples.
FULL = 2048


def serve(link: Link, board: Board, line: Line, speed: float, once: bool, ended: Callable[[], bool]) -> None:
    """Serve one host after another; `once` ends after the first has gone."""
    seen = False
    while not ended():
        if not link.connected():
            if seen and once:
                return
            line.clear()
            board.hang_up(time.monotonic())
            board.poll(time.monotonic(), room=True)
            link.wait(0.05)
            continue
        seen = True
        busy = _turn(link, board, line, speed)
        if busy is None:
            return
        link.wait(0.0 if busy else TICK_S if speed else 0.0005)


def _turn(link: Link, board: Board, line: Line, speed: float) -> bool | None:
    """One round; whether bytes moved at full speed, None when the line is gone for good."""
    now = time.monotonic()
    if not line.holds(now):
        board.receive(link.read(), now)
    fault = line.strikes(board.sampled_s)
    if fault is not None and not _strike(fault, link, board, line, now):
        return None
    room = line.waiting < FULL and not line.holds(now) and (speed > 0.0 or link.untaken() < FULL)
    for frame in board.poll(now, room):
        line.put(frame, now)
    out = line.due(now)
    taken = link.write(out) if out else 0
    line.back(out[taken:], now)
    return speed == 0.0 and taken > 0


def _strike(fault: Fault, link: Link, board: Board, line: Line, now: float) -> bool:
    """Carry out a fault that strikes once; False when there is no line any more."""
    if fault.name == "unplug":
        line.clear()
        link.unplug()
        return link.reusable
    if fault.name == "reboot":
        board.reboot(now)
        line.clear()
    if fault.name == "stop-contact":
        board.contact(True, now)
    line.hold(now + fault.amount)
    return True
