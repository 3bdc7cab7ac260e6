"""The protocol's page is right: its fields are the codec's, its examples are read as it says, byte by byte.

The examples, in docs/frames.txt, are taken apart here with struct and zlib alone, from what they say about each byte.
"""

import re
import struct
import zlib
from pathlib import Path
from typing import Any

import pytest
from wire_messages import stuff

from firmware_protocol import TYPE_OF, ChannelDescription, Decoder, encode
from firmware_protocol.layout import CHANNEL_FIELDS, TABLE

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "protocol.md").read_text("utf-8")
FRAMES = (DOCS / "frames.txt").read_text("utf-8")
SECTIONS = {
    int(code, 16): text
    for code, text in re.findall(r"^### [A-Z_]+ \(type 0x(\w\w), .*?\)\n(.*?)(?=^##|\Z)", PAGE, re.M | re.S)
}
EXAMPLES = {
    int(code, 16): text
    for code, text in re.findall(r"^[A-Z_]+ \(type 0x(\w\w), .*?\)\n(.*?)(?=^$|\Z)", FRAMES, re.M | re.S)
}
CODES = {"u8": "<B", "u16": "<H", "u32": "<I", "u64": "<Q", "f64": "<d"}
WRITTEN_AS = {
    "reset cause": "u8",
    "nack code": "u8",
    "event kind": "u8",
    "holder state": "u8",
    "holder reason": "u8",
    "format": "u8",
    "format or 0": "u8",
    "f64 or NaN": "f64",
}
LINE = re.compile(r"^ +(\d+)  ((?:[0-9A-F]{2} ?)+?)  +(\w+) +(\w+) +(.*)$")


def annotated(example: str) -> tuple[list[tuple[int, bytes, str, str, str]], bytes]:
    """The lines of an example (position, bytes, written as, field, value) and the frame as it is sent."""
    parts, wire = example.split("sent:\n")
    lines: list[tuple[int, bytes, str, str, str]] = []
    for text in parts.splitlines():
        match = LINE.match(text)
        if match:
            at, data, written, field, value = match.groups()
            lines.append((int(at), bytes.fromhex(data), written, field, value))
        else:
            at, data, written, field, value = lines.pop()
            lines.append((at, data + bytes.fromhex(text), written, field, value))
    return lines, bytes.fromhex(wire)


def test_every_message_has_a_section_and_an_example() -> None:
    assert sorted(SECTIONS) == sorted(EXAMPLES) == sorted(TYPE_OF.values())


@pytest.mark.parametrize("code", SECTIONS)
def test_the_list_of_a_message_has_the_codecs_fields_in_order(code: int) -> None:
    fields = next(fields for number, _, fields in TABLE if number == code)
    expected = [(name, WRITTEN_AS.get(kind.name, kind.name)) for name, kind in fields]
    if code == 0x82:
        expected += [(name, WRITTEN_AS.get(kind.name, kind.name)) for name, kind in CHANNEL_FIELDS]
    assert re.findall(r"^- `(\w+)` (\w+): ", SECTIONS[code], re.M) == expected


@pytest.mark.parametrize("code", EXAMPLES)
def test_every_byte_of_an_example_means_what_stands_beside_it(code: int) -> None:
    lines, wire = annotated(EXAMPLES[code])
    position = 0
    for at, data, written, field, value in lines:
        assert at == position, field
        position += len(data)
        if written == "text":
            assert data == bytes((len(data) - 1,)) + value.strip('"').encode(), field
        elif written == "samples":
            assert data == struct.pack(f"<{len(data) // 2}h", *map(int, value.split())), field
        else:
            number = float(value) if written == "f64" else int(value)
            assert data == struct.pack(CODES[written], number), field
    plain = b"".join(data for _, data, *_ in lines)
    assert zlib.crc32(plain[:-4]) == int(lines[-1][4])
    assert wire == stuff(plain) + b"\x00"


def parsed(lines: list[tuple[int, bytes, str, str, str]]) -> dict[str, Any]:
    """The body's values by field name, as the page writes them."""
    values: dict[str, Any] = {}
    for _, data, written, field, value in lines[5:-1]:
        if field in ("length", "channels") and "format" in values and "n" not in values:
            continue
        values[field] = (
            data if written == "samples" else value.strip('"') if written == "text" else float(value)
        )
    return values


@pytest.mark.parametrize("code", EXAMPLES)
def test_the_codec_reads_the_values_of_an_example_and_sends_its_bytes(code: int) -> None:
    lines, wire = annotated(EXAMPLES[code])
    (got,) = Decoder().feed(wire)
    assert TYPE_OF[type(got.message)] == code
    values = parsed(lines)
    seen = dict(vars(got.message))
    for channel in seen.pop("channels", ()) if code == 0x82 else ():
        assert isinstance(channel, ChannelDescription)
        seen |= vars(channel)
    assert seen == values
    assert got.sequence == int(lines[4][4])
    assert encode(got.message, got.sequence, got.stream) == wire


def test_the_checksums_check_value_on_the_page_is_zlibs() -> None:
    assert f"0x{zlib.crc32(b'123456789'):08X}" in PAGE


def test_the_stuffing_example_on_the_page_holds() -> None:
    before, after = re.search(r"So\s+`([0-9 ]+)` becomes `([0-9 ]+)`", PAGE).groups()
    assert stuff(bytes.fromhex(before)) == bytes.fromhex(after)
