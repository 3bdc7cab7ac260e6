"""The C header and the Python codec are the same wire."""

import random
import subprocess
from pathlib import Path

import pytest
from c_compiler import C_FOLDER, HERE, SANITIZE, STRICT, build
from wire_lines import RandomMessages, line_of
from wire_messages import frame

from firmware_protocol import TYPE_OF, Decoder, encode

GOLDEN = HERE / "golden.txt"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("c") / "wire_driver"
    return build(out, [HERE / "wire_driver.c"], STRICT + SANITIZE)


def ask(driver: Path, lines: list[str]) -> list[str]:
    """Send the lines, return the answers, one each; a complaint of the sanitizers fails the test."""
    text = "\n".join(lines) + "\n"
    done = subprocess.run([driver], input=text, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    answers = done.stdout.splitlines()
    assert len(answers) == len(lines)
    return [answer.rstrip() for answer in answers]


def golden() -> list[tuple[str, str]]:
    """Pairs of message line and frame in hexadecimal."""
    pairs = []
    for text in GOLDEN.read_text("utf-8").splitlines():
        if text and not text.startswith("#"):
            line, wire = text.split(" : ")
            pairs.append((line, wire))
    return pairs


def test_golden_vectors_hold_every_message() -> None:
    assert {int(line.split()[0]) for line, _ in golden()} == set(TYPE_OF.values())


def test_golden_vectors_are_what_python_reads_and_sends() -> None:
    for line, wire in golden():
        (got,) = Decoder().feed(bytes.fromhex(wire))
        assert line_of(got) == line
        assert encode(got.message, got.sequence, got.stream).hex() == wire


def test_golden_vectors_are_what_c_reads_and_sends(driver: Path) -> None:
    lines, wires = zip(*golden(), strict=True)
    assert ask(driver, [f"E {line}" for line in lines]) == list(wires)
    assert ask(driver, [f"D {wire}" for wire in wires]) == list(lines)


def test_ten_thousand_random_messages_are_the_same_in_both_languages(driver: Path) -> None:
    source = RandomMessages(seed=20)
    frames = [source.frame() for _ in range(10_000)]
    lines = [line_of(sent) for sent in frames]
    wires = [encode(sent.message, sent.sequence, sent.stream).hex() for sent in frames]
    assert ask(driver, [f"E {line}" for line in lines]) == wires
    assert ask(driver, [f"D {wire}" for wire in wires]) == lines


def test_both_languages_take_and_refuse_the_same_damaged_frames(driver: Path) -> None:
    rng, source = random.Random(5), RandomMessages(seed=6)
    pieces = []
    for _ in range(10_000):
        sent = source.frame()
        wire = bytearray(encode(sent.message, sent.sequence, sent.stream))
        for _ in range(rng.randrange(3)):
            at = rng.randrange(len(wire))
            wire[at : at + rng.randrange(3)] = rng.randbytes(rng.randrange(3))
        pieces.append(bytes(wire))
    decoder = Decoder()
    python = [line_of(got) for piece in pieces for got in decoder.feed(piece)]
    answers = [
        a for text in ask(driver, [f"D {piece.hex()}" for piece in pieces]) for a in text.split("; ") if a
    ]
    assert [answer for answer in answers if answer[0].isdigit()] == python
    counts = decoder.statistics
    assert answers.count("bad cobs") == counts.bad_cobs > 100
    assert answers.count("bad checksum") == counts.bad_checksum > 1000
    assert answers.count("too short") == counts.too_short
    assert answers.count("too long") == counts.too_long


def test_garbage_is_safe_in_c(driver: Path) -> None:
    rng = random.Random(7)
    lines = [f"D {rng.randbytes(rng.choice((3, 40, 1500, 5000))).hex()}" for _ in range(500)]
    assert not any(answer[:1].isdigit() for text in ask(driver, lines) for answer in text.split("; "))


def test_a_message_that_does_not_fit_is_refused_in_c(driver: Path) -> None:
    samples = "01" * 990
    assert ask(driver, [f"E 133 0 0 0 0 0 495 1 1 ={samples}", "E 200 0 0"]) == ["-", "-"]


def test_another_version_and_an_unknown_type_are_distinguished_in_c(driver: Path) -> None:
    lines = [f"D {frame(bytes((2, 1)) + bytes(6)).hex()}", f"D {frame(bytes((1, 0xC0)) + bytes(6)).hex()}"]
    assert ask(driver, lines) == ["other version", "unknown"]


@pytest.mark.parametrize("flags", [["-Os"], ["-O3"], ["-DWIRE_RECEIVE_MAX=64", "-Os"]])
def test_the_header_compiles_without_a_warning(tmp_path: Path, flags: list[str]) -> None:
    build(tmp_path / "driver", [HERE / "wire_driver.c"], STRICT + flags)


def test_the_header_is_good_cpp_for_boards_that_are_programmed_in_it(tmp_path: Path) -> None:
    source = tmp_path / "sketch.cpp"
    source.write_text(
        '#include "wire.h"\n'
        "int main() { uint8_t out[WIRE_MAX_SENT]; wire_message m = wire_message(); m.type = WIRE_STOP;\n"
        "  return wire_encode(out, &m, 0, 0) == 0; }\n"
    )
    flags = ["-std=c++11", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    build(tmp_path / "sketch", [source], flags, name="c++")


def test_the_header_stands_alone() -> None:
    includes = [
        text for text in (C_FOLDER / "wire.h").read_text().splitlines() if text.startswith("#include")
    ]
    assert includes == [f"#include <{name}.h>" for name in ("stdbool", "stddef", "stdint", "string")]
