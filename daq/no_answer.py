"""Why no board answered: silence, noise, or frames that are sound and are not understood."""

from daq.errors import NoBoard, ProtocolError, Stalled, StationError
from firmware_protocol import Statistics

NOISE_PIECES = 10


def no_answer(port: str, seconds: float, counts: Statistics, said_hello: bool) -> StationError:
    """Return the error for the handshake on `port` that `counts` tells of, after so many seconds.

    NoBoard where nothing of a board came, ProtocolError where frames came whole.
    """
    sound = counts.frames + counts.malformed + counts.unknown
    if not counts.bytes:
        return NoBoard(
            f"{port}: nothing answered within {seconds:g} s; is the board there and powered, and no other program using "
            "this port?"
        )
    if not sound:
        return NoBoard(
            f"{port}: {counts.bytes} bytes came within {seconds:g} s, but no answer of a board;"
            " check baud rate and port"
        )
    what = f"{sound} frames came whole within {seconds:g} s, and none was the HELLO that was asked for"
    if said_hello:
        what = "the board says HELLO and does not describe its channels"
    if counts.malformed:
        what += f"; {counts.malformed} frames are sound but not understood ({counts.why_malformed})"
    if counts.too_long:
        what += f"; {counts.too_long} were longer than a frame may be"
    return ProtocolError(f"{port}: {what}. The line is good, the firmware needs a correction")


def unanswered(port: str, what: str, counts: Statistics, silent: bool) -> StationError:
    """Return the error for a request `what` without an answer, after which nothing sound came where `silent`."""
    if silent and is_noisy(counts):
        return Stalled(
            f"{port}: no answer to {what} came through the noise ({counts.damaged} damaged pieces so far);"
            " check cable, baud rate and what else speaks on this line"
        )
    if silent:
        return Stalled(f"{port}: the board fell silent and did not answer {what}; reset it")
    return ProtocolError(f"{port}: the board does not answer {what}; its firmware needs a correction")


def is_noisy(counts: Statistics) -> bool:
    """Check whether more damaged pieces than sound frames came."""
    return counts.damaged > max(counts.frames, NOISE_PIECES)
