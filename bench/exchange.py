"""Lines of other boards and files for other programs: how many lines a second are read, how slow exports are."""

import time

import numpy as np

from daq.exporting import FORMATS, Exported, encode
from daq.recording import Channel, Recording
from daq.sources.line_source import LineSource
from daq.sources.open_source import LineOptions

TITLE = "Lines read, files written"
RATE = 256.0
AT_ONCE = 4096

FORMS = {
    "separated by commas": lambda i, u, a: f"{i * 1000 // 256},{u:.3f},{a:.5f}",
    "names with values": lambda i, u, a: f"t:{i * 1000 // 256} x:{u:.3f} a:{a:.5f}",
    "JSON": lambda i, u, a: f'{{"t": {i * 1000 // 256}, "x": {u:.3f}, "a": {a:.5f}}}',
}


class Printed:
    """A port that gives lines as fast as they are taken."""

    name = "lines in memory"

    def __init__(self, lines: list[str]) -> None:
        self._data = "".join(f"{line}\r\n" for line in lines).encode()
        self._at = 0

    def read(self) -> bytes:
        """Return the next piece."""
        part = self._data[self._at : self._at + AT_ONCE]
        self._at += len(part)
        return part

    def write(self, data: bytes) -> None:
        """Take nothing."""

    def close(self) -> None:
        """Nothing is open."""


def lines_a_second(form: str, count: int) -> float:
    """Return how many lines of three columns become samples in a second of this process."""
    random = np.random.default_rng(1)
    motion, push = 1e3 * random.normal(size=count), random.normal(size=count)
    lines = [FORMS[form](i, u, a) for i, (u, a) in enumerate(zip(motion, push, strict=True))]
    named = form != "separated by commas"
    columns = {
        "time": "t" if named else 1,
        "displacement": "x" if named else 2,
        "acceleration": "a" if named else 3,
    }
    units = {"time": "ms", "displacement": "um", "acceleration": "m/s^2"}
    source = LineSource(Printed(lines), LineOptions(None, columns, units).decide, listen_s=0.0)
    source.start()
    began, taken = time.perf_counter(), 0
    while (got := sum(len(reading.samples) for reading in source.read())) or not taken:
        taken += got
    return taken / (time.perf_counter() - began)


def export_cell(form: str, seconds: float) -> str:
    """Return the time of one format: two channels, `seconds` long."""
    n = round(seconds * RATE)
    random = np.random.default_rng(2)
    channels = (Channel("u", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    recording = Recording(RATE, channels, random.normal(size=(2, n)), np.ones(n, dtype=bool))
    exported = Exported(recording, {"session": "bench"})
    encode(exported, form)  # imports its library
    began = time.perf_counter()
    encode(exported, form)
    return f"{1e3 * (time.perf_counter() - began):.0f} ms"


def run(quick: bool) -> str:
    """Return the section of the benchmark page."""
    count = 20_000 if quick else 100_000
    lines = ", ".join(f"{lines_a_second(form, count):,.0f} {form}" for form in FORMS)
    exports = ", ".join(f"{form} {export_cell(form, 120.0)}" for form in FORMATS)
    return f"Lines of three columns a second, from memory to SI units: {lines}.\n\nExports of 120 s of two channels: {exports}."
