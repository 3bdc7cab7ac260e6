"""Files that were made to take all the time or all the memory: each is read or refused, in time and under 1 GB."""

import json
import os
import struct
import subprocess
import sys
import zlib
from functools import cache
from pathlib import Path

import pytest

from daq.sources.text_lines import parse_line
from station.cli import run

LIMIT_S = 400  # to end a hang; what is read takes seconds
GIGABYTE = 1_000_000_000
READ = """
import re, sys
from daq.errors import StationError
from daq.importing import read_file
for name in sys.argv[1:]:
    print(name, flush=True)
    try:
        read_file(name)
    except StationError as refusal:
        assert 0 < len(str(refusal)) < 2000, refusal
# Not of getrusage, which begins with what the process had that started this one.
found = re.search(r"VmHWM:\\s*(\\d+) kB", open("/proc/self/status").read()) if sys.platform == "linux" else None
print(1024 * int(found[1]) if found else 0)
"""
REPEATED = (
    "ab ", "x (", "_m", "displacement_m", " ", "1", "(", "[", ",", ":", "=", "/", "a/", "1,1", "a.1.", "_", "-", "\t",
    '"', "a in ", "a: ", "sampl ", "12:34:", "1.", "1e", "# ", "unit ", "x1_", "\u00b2", "a;", "{", "fs ", "1 000", "Run ",
)  # fmt: skip
LENGTH = 100_000
ROWS = "".join(f"{i / 100:.3f},{0.01 * (-1) ** i:.5f}\n" for i in range(200))


def peak_of_reading(*files: Path) -> int:
    """Read files in a process of its own, one after the other; return the most memory that it had, bytes."""
    command = [sys.executable, "-c", READ, *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S)
    assert done.returncode == 0, done.stdout + done.stderr
    return int(done.stdout.splitlines()[-1])


@cache
def peak_of_nothing() -> int:
    """Return what the program takes that reads no file, bytes."""
    return peak_of_reading()


def texts(piece: str) -> list[str]:
    """A piece repeated where a file has names, settings, rows."""
    long = (piece * (LENGTH // len(piece) + 1))[:LENGTH]
    cell = long.replace(",", ";")
    samples = {"time": [i / 100 for i in range(100)], "x": [(-1) ** i * 0.01 for i in range(100)]}
    return [
        f"time,{cell}\n{ROWS}",
        f"time,displacement {cell}!\n{ROWS}",
        f"# {long}\ntime,x\n{ROWS}",
        f"{long}x\n" + "".join(f"{i % 7}\n" for i in range(100)),
        f"time,x\ns,{cell}\n{ROWS}",
        f"time,x\n{ROWS}2.00,{long}\n",
        "".join(f"a: {i} {long if i == 20 else 'b: 2'}\n" for i in range(60)),
        json.dumps({**samples, long: samples["x"], f"{long} units": "mm", "info": {f"{long}_rate": 1.0}}),
    ]


@pytest.mark.parametrize("some", [REPEATED[::4], pytest.param(REPEATED[1::2], marks=pytest.mark.slow)])
def test_a_long_text_is_read_or_refused_at_once(tmp_path: Path, some: tuple[str, ...]) -> None:
    files = []
    for i, text in enumerate(text for piece in some for text in texts(piece)):
        files.append(tmp_path / f"{i}.csv")
        files[-1].write_text(text, encoding="utf-8")
    peak_of_reading(*files)


def element(kind: int, data: bytes) -> bytes:
    return struct.pack("<II", kind, len(data)) + data + b"\0" * (-len(data) % 8)


def array(kind: int, rows: int, columns: int, content: bytes) -> bytes:
    head = element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack("<ii", rows, columns))
    return element(14, head + element(1, b"c") + content)


HEAD = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM"
ONE = array(6, 1, 1, element(9, struct.pack("<d", 1.0)))
UNFOLDING = {
    "arrays.mat": lambda: HEAD + array(1, 1, 150_000, ONE * 150_000),
    "packed.mat": lambda: (
        HEAD + struct.pack("<II", 15, len(z := zlib.compress(array(1, 1, 200_000, ONE * 200_000)))) + z
    ),
    "pairs.csv": lambda: b"1,2\n" * 20_000_000,
    "newlines.csv": lambda: b"\n" * 90_000_000,
    "returns.csv": lambda: b"\r" * 90_000_000,
    "remarks.csv": lambda: b"1,2\n2,3\n3,1\n" * 100 + (b"1," * 99_000 + b"1\n") * 90,
    "scope.csv": lambda: (b"," * 60 + b"\n") * 140_000,
    "lists.json": lambda: b"[" + b"[1,2]," * 16_000_000 + b"[1,2]]",
    "keys.json": lambda: b"[" + b",".join(b'{"k%d":1}' % i for i in range(70_000)) + b"]",
    "deep.json": lambda: b'{"a":' * 980 + b"1" + b"}" * 980,
}

PARTS = {"arrays.mat": 10, "packed.mat": 10, "remarks.csv": 5, "scope.csv": 10, "keys.json": 10}
"""One of so many parts of the largest that is read: what it takes grows with the file."""

SLOW = [pytest.mark.slow]


def share_of_limit(file: Path, share: int) -> bool:
    """Read a file that is one of `share` such parts; check that the whole would stay under the limit."""
    program = peak_of_nothing()
    return peak_of_reading(file) - program < (GIGABYTE - program) / share


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(
            n,
            marks=SLOW if n == "returns.csv" else [],
        )
        for n in UNFOLDING
    ],
)
@pytest.mark.skipif(sys.platform != "linux", reason="the peak of memory is asked of Linux")
def test_a_file_that_unfolds_stays_under_the_limit(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(UNFOLDING[name]())
    assert share_of_limit(tmp_path / name, PARTS.get(name, 1))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the peak of memory is asked of Linux")
@pytest.mark.parametrize(
    ("line", "count"),
    [
        (b"1.2345678,2.2345678,3.3456789,4.3456789,5.3456789\n", 1_450_000),
        (b"1,25 mm 3,05 g 1,12 N\n", 990_000),
    ],
)
def test_the_largest_tables_that_are_read_stay_under_the_limit(
    tmp_path: Path, line: bytes, count: int
) -> None:
    (tmp_path / "a.csv").write_bytes(line * (count // 10))
    assert share_of_limit(tmp_path / "a.csv", 10)


def test_a_line_of_a_board_is_looked_at_once() -> None:
    code = "from daq.sources.text_lines import *; parse_line('a' * 1000 + ' ' * 3000); header_of(' ' * 4096)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=LIMIT_S)
    found = parse_line("roll angle: 1.5, T=20 x:12abc")
    assert found is not None
    assert found == {"roll angle": 1.5, "T": 20.0}


@pytest.mark.skipif(sys.platform in ("win32", "darwin"), reason="names of files are Unicode there")
def test_a_file_whose_name_is_not_utf8_is_imported_whole(tmp_path: Path) -> None:
    name = os.fsdecode(b"a\xff:.csv")
    (tmp_path / name).write_text("time_s,displacement_m\n" + ROWS)
    command = [sys.executable, "-m", "station", "import", name, "--session", "s"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=LIMIT_S)
    assert done.returncode == 0, done.stderr
    assert [file.name for file in (tmp_path / "s" / "source").iterdir()] == ["a__.csv"]
    assert run(["verify", str(tmp_path / "s")]) == 0
