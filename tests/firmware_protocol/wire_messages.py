"""Any message of the wire, for hypothesis and for a seeded generator; and COBS written out by hand."""

import struct
import zlib

from hypothesis import strategies as st

from firmware_protocol import (
    Ack,
    ChannelDescription,
    Clock,
    Config,
    Data,
    Describe,
    End,
    Event,
    EventKind,
    Heartbeat,
    Hello,
    HelloRequest,
    Hold,
    Holder,
    HolderReason,
    HolderState,
    Log,
    Nack,
    NackCode,
    Release,
    Resend,
    ResetCause,
    SampleFormat,
    Start,
    Stop,
    TimeSync,
)

u8 = st.integers(0, 2**8 - 1)
u16 = st.integers(0, 2**16 - 1)
u32 = st.integers(0, 2**32 - 1)
u64 = st.integers(0, 2**64 - 1)
number = st.floats(allow_nan=False)
number_or_none = st.none() | number
formats = st.sampled_from(SampleFormat)


def text(longest: int = 20) -> st.SearchStrategy[str]:
    """Texts of at most `longest` characters, four bytes each in UTF-8 at most."""
    return st.text(st.characters(codec="utf-8"), max_size=longest)


channels = st.builds(
    ChannelDescription,
    name=text(5),
    quantity=st.sampled_from(["displacement", "velocity", "acceleration", "force", "other"]),
    unit=st.sampled_from(["m", "m/s", "m/s^2", "N", "rad", "°C"]),
    scale=number,
    offset=number,
    rate_hz=number,
    low=number_or_none,
    high=number_or_none,
    resolution=number_or_none,
    group_delay_s=number,
    sensor=text(5),
)


@st.composite
def data(draw: st.DrawFn) -> Data:
    """DATA of up to 960 bytes of samples."""
    form, width = draw(formats), draw(st.integers(1, 8))
    n = draw(st.integers(0, 960 // (width * form.size)))
    samples = draw(st.binary(min_size=n * width * form.size, max_size=n * width * form.size))
    return Data(draw(u64), draw(u64), draw(u32), n, width, form, samples)


messages = st.one_of(
    st.builds(HelloRequest, major=u8, minor=u8),
    st.builds(Config, rate_hz=number, samples_per_frame=u16, format=st.none() | formats),
    st.builds(Start, count=u64),
    st.builds(Stop),
    st.builds(Resend, first=u64, count=u32),
    st.builds(TimeSync, host_time_us=u64, board_time_us=u64),
    st.builds(
        Hello,
        boot_id=u32,
        clock_hz=u32,
        reset_cause=st.sampled_from(ResetCause),
        major=u8,
        minor=u8,
        firmware=text(),
        board=text(),
        unique_id=text(),
    ),
    st.builds(Describe, format=formats, channels=st.lists(channels, max_size=5).map(tuple)),
    st.builds(Ack, request_sequence=u32, request_type=u8),
    st.builds(Nack, request_sequence=u32, request_type=u8, code=st.sampled_from(NackCode), text=text(60)),
    data(),
    st.builds(Heartbeat, uptime_us=u64, buffer_fill_percent=u8, dropped_total=u64),
    st.builds(Event, kind=st.sampled_from(EventKind), index=u64, count=u32, channel=u8, text=text(60)),
    st.builds(End, total_samples=u64, total_dropped=u64, checksum=u32),
    st.builds(Log, text=text(60)),
    st.builds(Clock, error_ppm=number),
    st.builds(Hold, ticket=u32, displacement=number),
    st.builds(Release, ticket=u32),
    st.builds(
        Holder,
        low=number,
        high=number,
        silence_s=number,
        ticket=u32,
        state=st.sampled_from(HolderState),
        reason=st.sampled_from(HolderReason),
        displacement=number,
        sample=u64,
    ),
)


def stuff(plain: bytes) -> bytes:
    """COBS as the page describes it, piece by piece: slow, and not the library that the codec uses."""
    stuffed = bytearray()
    for piece in plain.split(b"\x00"):
        for at in range(0, len(piece) - 253, 254):
            stuffed += b"\xff" + piece[at : at + 254]
        rest = piece[len(piece) // 254 * 254 :]
        stuffed += bytes((len(rest) + 1,)) + rest
    last = plain.rsplit(b"\x00", 1)[-1]
    ends_in_full_piece = len(last) > 0 and len(last) % 254 == 0
    return bytes(stuffed[:-1] if ends_in_full_piece else stuffed)


def frame(plain: bytes) -> bytes:
    """A whole frame around header and body."""
    return stuff(plain + struct.pack("<I", zlib.crc32(plain))) + b"\x00"
