"""Read a file of any known format: one importer a format, chosen by what the file is."""

from pathlib import Path

from daq.importing.assemble import assemble
from daq.importing.csv_text import read_csv
from daq.importing.errors import problem
from daq.importing.matlab import is_matlab, read_matlab
from daq.importing.options import ImportOptions
from daq.importing.uff58 import is_uff, read_uff
from daq.recording import Recording

MAX_BYTES = 1_000_000_000


def read_file(path: Path, options: ImportOptions | None = None) -> Recording:
    """Return the recording in a file of another board: text table, MATLAB v5 or UFF58.

    What was understood and what was guessed stands in the recording's notes. Raises ImportProblem, one
    sentence with file, line and column where there are any.
    """
    options = options or ImportOptions()
    path = Path(path)
    data = _bytes(path)
    if is_matlab(data):
        return assemble(read_matlab(path, data, options), options)
    if is_uff(data):
        return assemble(read_uff(path, data, options), options)
    return assemble(read_csv(path, data, options), options)


def _bytes(path: Path) -> bytes:
    """Return the contents of a file. Raises ImportProblem when there is none, or it is not a plain file."""
    try:
        if path.is_dir():
            raise problem(path, "is a folder", "name a file in it")
        if not path.is_file():
            there = path.exists()
            raise problem(
                path, "is not a plain file" if there else "does not exist", "name a file with a recording"
            )
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise problem(
                path, f"has {size / 1e6:.0f} MB, more than {MAX_BYTES / 1e6:.0f} MB", "cut it to the releases"
            )
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise problem(path, f"cannot be read ({reason})", "check the name and the permissions") from None
    if not data.strip(b"\0 \t\r\n"):
        raise problem(path, "is empty", "record again or name another file")
    return data
