"""Sources by what the operator says: lines of a port or of a growing file, a sound card, a class of one's own."""

import os
import runpy
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from daq.errors import LinkLost, OperatorError, PortError
from daq.port import BAUD, Port, open_port
from daq.sources.audio_input import AudioInput
from daq.sources.line_format import LineFormat, Sample, find_format
from daq.sources.line_source import LineSource
from daq.sources.source import Source

AUDIO = "audio"
AUDIO_RATE = 8000.0
WAIT_S = 0.03
BIGGEST_READ = 1 << 16


class GrowingFile:
    """A port (see `daq.port.Port`) that gives what is added to a file after it was opened."""

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        try:
            self._file = path.open("rb", buffering=0)
        except OSError as error:
            raise PortError(f"{path}: cannot be read ({error.strerror or error})") from error
        self._file.seek(0, os.SEEK_END)

    def read(self) -> bytes:
        """Return the bytes added since; b"" for none. Raises LinkLost where the file became shorter."""
        data = self._file.read(BIGGEST_READ) or b""
        if not data:
            if os.fstat(self._file.fileno()).st_size < self._file.tell():
                raise LinkLost(
                    f"{self.name}: the file was cut off while it was read; what came before is kept"
                )
            time.sleep(WAIT_S)
        return data

    def write(self, data: bytes) -> None:
        """Do nothing: a file is only read."""

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@dataclass(frozen=True)
class LineOptions:
    """What is told of the lines: a profile's format, or columns and units as in an import; the rate and the baud rate."""

    form: LineFormat | None = None
    columns: Mapping[str, str | int] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    rate_hz: float | None = None
    baud: int | None = None

    def decide(self, sample: Sample) -> LineFormat:
        """Return the format of lines that were listened to. Raises OperatorError where a profile does not fit them."""
        if self.form is None:
            return find_format(sample, self.columns, self.units, self.rate_hz)
        missing = [c for c in self.form.columns if c not in sample.columns]
        if missing:
            raise OperatorError(
                f"the lines have no column {', '.join(missing)}, which the profile names; they have "
                f"{', '.join(sample.columns)}"
            )
        return self.form


def open_lines(port: str, options: LineOptions) -> LineSource:
    """Open a port, or a file that grows, whose lines are samples, and listen for some seconds."""
    return LineSource(open_bytes(port, options), options.decide)


def open_bytes(port: str, options: LineOptions) -> Port:
    """Open what the bytes of lines come from."""
    path = Path(port)
    if "://" not in port and path.is_file():
        return GrowingFile(path)
    known = options.form.baud if options.form is not None else None
    return open_port(port, options.baud or known or BAUD)


def open_source(text: str, options: LineOptions) -> Source:
    """Open `audio`, `audio:DEVICE`, or `FILE.py:CLASS`, a class with the four calls of `daq.sources.source`."""
    if text == AUDIO or text.startswith(f"{AUDIO}:"):
        return AudioInput(text[len(AUDIO) + 1 :] or None, options.rate_hz or AUDIO_RATE, options.units)
    file, _, name = text.rpartition(":")
    path = Path(file)
    if not name.isidentifier() or path.suffix != ".py" or not path.is_file():
        raise OperatorError(f"'{text}' is no source; say audio, audio:DEVICE or FILE.py:CLASS")
    try:
        made = runpy.run_path(str(path), run_name=f"source_{path.stem}").get(name)
    except Exception as error:
        raise OperatorError(f"{path}: {type(error).__name__}: {error}") from error
    if made is None:
        raise OperatorError(f"{path}: has no class {name}")
    found: Source = made()
    lacking = [
        call for call in ("describe", "start", "read", "close") if not callable(getattr(found, call, None))
    ]
    if lacking:
        raise OperatorError(
            f"{path}: {name} lacks {', '.join(lacking)}; a source has describe, start, read and close"
        )
    return found
