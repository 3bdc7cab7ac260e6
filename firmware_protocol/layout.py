"""The byte table: which field of which message stands where, little-endian and without padding.

A body is its numbers in the table's order, then its tail: texts (a length byte and UTF-8), samples or
channels. Bytes after that belong to a later minor version and are skipped.
"""

from dataclasses import dataclass
from enum import IntEnum

from firmware_protocol import messages as m


@dataclass(frozen=True)
class Kind:
    """How one field is written: the `struct` code of a number, or a tail; `means` says which numbers."""

    name: str
    code: str = ""
    means: type[IntEnum] | None = None


U8, U16, U32, U64 = Kind("u8", "B"), Kind("u16", "H"), Kind("u32", "I"), Kind("u64", "Q")
F64 = Kind("f64", "d")
FORMAT = Kind("format", "B", m.SampleFormat)
FORMAT_OR_NONE = Kind("format or 0", "B", m.SampleFormat)
NUMBER_OR_NAN = Kind("f64 or NaN", "d")
TEXT, SAMPLES, CHANNELS = Kind("text"), Kind("samples"), Kind("channels")

Fields = tuple[tuple[str, Kind], ...]

CHANNEL_FIELDS: Fields = (
    ("scale", F64),
    ("offset", F64),
    ("rate_hz", F64),
    ("low", NUMBER_OR_NAN),
    ("high", NUMBER_OR_NAN),
    ("resolution", NUMBER_OR_NAN),
    ("group_delay_s", F64),
    ("name", TEXT),
    ("quantity", TEXT),
    ("unit", TEXT),
    ("sensor", TEXT),
)

TABLE: tuple[tuple[int, type, Fields], ...] = (
    (0x01, m.HelloRequest, (("major", U8), ("minor", U8))),
    (0x02, m.Config, (("rate_hz", F64), ("samples_per_frame", U16), ("format", FORMAT_OR_NONE))),
    (0x03, m.Start, (("count", U64),)),
    (0x04, m.Stop, ()),
    (0x05, m.Resend, (("first", U64), ("count", U32))),
    (0x06, m.TimeSync, (("host_time_us", U64), ("board_time_us", U64))),
    (0x07, m.Hold, (("ticket", U32), ("displacement", F64))),
    (0x08, m.Release, (("ticket", U32),)),
    (
        0x81,
        m.Hello,
        (
            ("major", U8),
            ("minor", U8),
            ("reset_cause", Kind("reset cause", "B", m.ResetCause)),
            ("boot_id", U32),
            ("clock_hz", U32),
            ("firmware", TEXT),
            ("board", TEXT),
            ("unique_id", TEXT),
        ),
    ),
    (0x82, m.Describe, (("format", FORMAT), ("channels", CHANNELS))),
    (0x83, m.Ack, (("request_sequence", U32), ("request_type", U8))),
    (
        0x84,
        m.Nack,
        (
            ("request_sequence", U32),
            ("request_type", U8),
            ("code", Kind("nack code", "B", m.NackCode)),
            ("text", TEXT),
        ),
    ),
    (
        0x85,
        m.Data,
        (
            ("first_index", U64),
            ("board_time_us", U64),
            ("dropped_before", U32),
            ("n", U16),
            ("channels", U8),
            ("format", FORMAT),
            ("samples", SAMPLES),
        ),
    ),
    (0x86, m.Heartbeat, (("uptime_us", U64), ("buffer_fill_percent", U8), ("dropped_total", U64))),
    (
        0x87,
        m.Event,
        (
            ("kind", Kind("event kind", "B", m.EventKind)),
            ("channel", U8),
            ("index", U64),
            ("count", U32),
            ("text", TEXT),
        ),
    ),
    (0x88, m.End, (("total_samples", U64), ("total_dropped", U64), ("checksum", U32))),
    (0x89, m.Log, (("text", TEXT),)),
    (0x8A, m.Clock, (("error_ppm", F64),)),
    (
        0x8B,
        m.Holder,
        (
            ("low", F64),
            ("high", F64),
            ("silence_s", F64),
            ("ticket", U32),
            ("state", Kind("holder state", "B", m.HolderState)),
            ("reason", Kind("holder reason", "B", m.HolderReason)),
            ("displacement", F64),
            ("sample", U64),
        ),
    ),
)

TYPE_OF: dict[type, int] = {cls: code for code, cls, _ in TABLE}
