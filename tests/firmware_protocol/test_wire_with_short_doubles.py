"""The C header where `double` has 32 bits, as on AVR: the same wire, numbers rounded to what the machine can hold."""

import math
import random
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest
from c_compiler import HERE, SANITIZE, STRICT, build
from wire_lines import line_of

from firmware_protocol import ChannelDescription, Clock, Config, Decoder, Describe, SampleFormat, encode


def numbers() -> list[float]:
    """Numbers of all sizes, ties between two 32-bit neighbours, and the edges of the 32-bit range."""
    rng = random.Random(3)
    edges = [
        0.0,
        -0.0,
        1.0,
        256.0,
        1e-6,
        math.inf,
        -math.inf,
        3.4028235e38,
        3.4028236e38,
        1e300,
        5e-324,
        2**-149.0,
    ]
    edges += [2**-150.0, 1.5 * 2**-150, 2**-126.0, 2**-126.0 - 2**-150, 1.1754943e-38]
    any_bits = [struct.unpack("<d", rng.randbytes(8))[0] for _ in range(2000)]
    in_range = [rng.choice((-1, 1)) * 2 ** rng.uniform(-152, 130) for _ in range(2000)]
    ties = [(2**23 + rng.randrange(2**23) + 0.5) * 2.0 ** rng.randrange(-172, 104) for _ in range(500)]
    return edges + any_bits + in_range + ties


def rounded(value: float) -> float:
    """The nearest 32-bit number, by numpy."""
    with np.errstate(over="ignore", under="ignore"):
        return float(np.float32(value))


def test_numbers_are_rounded_to_32_bits_as_ieee_754_says(tmp_path: Path) -> None:
    driver = build(tmp_path / "real", [HERE / "real_driver.c"], STRICT + SANITIZE)
    values = numbers()
    asked = "\n".join(struct.pack(">d", value).hex() for value in values)
    done = subprocess.run([driver], input=asked, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    got = [struct.unpack(">d", bytes.fromhex(line))[0] for line in done.stdout.split()]
    assert len(got) == len(values)
    for value, back in zip(values, got, strict=True):
        if math.isnan(value):
            assert math.isnan(back)
        else:
            assert struct.pack("<d", back) == struct.pack("<d", rounded(value)), value


@pytest.fixture(scope="module")
def short_driver(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("c") / "short_driver"
    return build(out, [HERE / "wire_driver.c"], [*STRICT, *SANITIZE, "-DWIRE_REAL=float"])


def described(*values: float) -> Describe:
    names = ("scale", "offset", "rate_hz", "low", "high", "resolution", "group_delay_s")
    fields = dict(zip(names, values, strict=True))
    channel = ChannelDescription(name="x", quantity="displacement", unit="m", sensor="LVDT 7", **fields)
    return Describe(SampleFormat.I16, (channel,))


def test_messages_with_fractions_pass_with_32_bits(short_driver: Path) -> None:
    exact = [1.094e-6, -0.0021, 256.0, -0.032, 0.032, math.nan, 0.00125]
    for sent, received in (
        (described(*exact), described(*map(rounded, exact))),
        (Config(rate_hz=1000 / 3), Config(rate_hz=rounded(1000 / 3))),
        (Clock(100 / 3), Clock(rounded(100 / 3))),
    ):
        (whole,) = Decoder().feed(encode(sent, 7))
        (short,) = Decoder().feed(encode(received, 7))
        asked = f"D {encode(sent, 7).hex()}\nE {line_of(whole)}\n"
        done = subprocess.run([short_driver], input=asked, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        line, wire = (answer.rstrip() for answer in done.stdout.splitlines())
        assert line == line_of(short)
        assert wire == encode(received, 7).hex()
