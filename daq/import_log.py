"""A recording from elsewhere as a raw log: the frames a board would have sent, with every bit of it kept."""

from math import isfinite
from zlib import crc32

import numpy as np

from daq.description_checks import MAX_RATE, data_of, description_of
from daq.errors import OperatorError
from daq.raw_log import Kind, RawLog
from daq.recording import Recording, runs
from firmware_protocol import End, Hello, Message, encode

ROOM_FOR_SAMPLES = 980
TOGETHER = 64  # frames in a record


def import_log(recording: Recording) -> RawLog:
    """Return a log whose decoding gives the same recording, sample for sample.

    OperatorError when one message cannot describe the channels or the rate is out of the wire's range.
    """
    if not (isfinite(recording.rate) and 0 < recording.rate <= MAX_RATE):
        raise OperatorError(f"a rate of {recording.rate:g} Hz cannot be stored; up to {MAX_RATE:g} Hz can")
    if not recording.valid.any():
        raise OperatorError("the recording holds no valid sample; there is nothing to store")
    try:
        hello = encode(Hello(boot_id=0, clock_hz=0, firmware="import"), 0)
        channels = encode(description_of(recording.channels, recording.rate), 1)
    except ValueError as error:
        n = len(recording.channels)
        raise OperatorError(f"{n} channels cannot be stored together: {error}") from error
    log = RawLog()
    log.append(Kind.RECEIVED, hello + channels)
    log.note(
        event="imported",
        gaps=[[gap.first, gap.count, gap.reason] for gap in recording.gaps],
        notes=list(recording.notes),
    )
    log.note(event="window", first=0, count=len(recording.valid), trigger=recording.trigger)
    messages = _messages(recording)
    for at in range(0, len(messages), TOGETHER):
        frames = (encode(one, sequence) for sequence, one in enumerate(messages[at : at + TOGETHER], at + 2))
        log.append(Kind.RECEIVED, b"".join(frames))
    return log


def _messages(recording: Recording) -> list[Message]:
    """Return DATA for every run of valid samples, and END."""
    table = np.ascontiguousarray(recording.samples.T)
    per_frame = max(ROOM_FOR_SAMPLES // (8 * len(recording.channels)), 1)
    messages: list[Message] = []
    check = 0
    for start, stop in runs(recording.valid):
        for first in range(start, stop, per_frame):
            data = data_of(first, first / recording.rate * 1e6, table[first : min(first + per_frame, stop)])
            check = crc32(data.samples, check)
            messages.append(data)
    lost = int(len(recording.valid) - recording.valid.sum())
    return [*messages, End(len(recording.valid), lost, check)]
