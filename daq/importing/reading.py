"""Read a file of any known format: one importer a format, chosen by what the file is."""

from dataclasses import replace
from pathlib import Path

from daq.importing.accelerometer import with_moving_axis
from daq.importing.assemble import assemble
from daq.importing.bob import with_angle
from daq.importing.counted_on import counted_on
from daq.importing.csv_text import read_csv
from daq.importing.degrees import agreed
from daq.importing.errors import ImportProblem, problem
from daq.importing.json_text import is_json, read_json
from daq.importing.limits import MAX_BYTES, require_size
from daq.importing.matlab import is_matlab, read_matlab
from daq.importing.options import ImportOptions
from daq.importing.runs import find_runs, without_still
from daq.importing.table import Table
from daq.importing.time_steps import with_stamps
from daq.importing.uff58 import is_uff, read_uff
from daq.recording import Recording


def read_file(
    path: str | Path, options: ImportOptions | None = None, run: str | int | None = None
) -> Recording:
    """Return the recording in a file of another board: text table, JSON, MATLAB v5 or UFF58.

    `run` is the run to read where the file holds several; it stands for the field of the same name in `options`.
    What was understood and what was guessed stands in the recording's notes. Raises ImportProblem, one
    sentence with file, line and column where there are any, also when the file holds several runs and none is named.
    """
    found = read_runs(path, options, run)
    if len(found) > 1:
        names = ", ".join(recording.run for recording in found)
        raise problem(
            Path(path), f"holds {len(found)} runs ({names})",
            f"name one, as in --run {found[0].run}, or in Python read_recordings(...)",
        )  # fmt: skip
    return found[0]


def read_runs(
    path: str | Path, options: ImportOptions | None = None, run: str | int | None = None
) -> tuple[Recording, ...]:
    """Return the recordings in a file, one for each run in it, in the order of the file; usually there is one.

    A run that cannot be read is left out, and the notes of the others say why. Raises ImportProblem as `read_file`,
    and when no run can be read.
    """
    options = options or ImportOptions()
    if run is not None:
        options = replace(options, run=run)
    path = Path(path)
    tables = _chosen(path, find_runs(_table(path, _bytes(path), options), options), options)
    tables, still = without_still(tables) if len(tables) > 1 else (tables, ())
    made: list[Recording] = []
    refused: list[ImportProblem] = []
    for table in agreed(tables, options):
        try:
            whole = with_stamps(counted_on(table, options), options)
            made.append(assemble(with_angle(with_moving_axis(whole, options), options), options))
        except ImportProblem as refusal:
            refused.append(refusal)
    if not made:
        raise refused[0]
    notes = (*still, *(f"a run was left out: {refusal}" for refusal in refused))
    return tuple(replace(recording, notes=(*recording.notes, *notes)) for recording in made)


def _table(path: Path, data: bytes, options: ImportOptions) -> Table:
    if is_matlab(data):
        return read_matlab(path, data, options)
    if is_uff(data):
        return read_uff(path, data, options)
    if is_json(data):
        return read_json(path, data, options)
    return read_csv(path, data, options)


def _chosen(path: Path, tables: list[Table], options: ImportOptions) -> list[Table]:
    """Return the run that the operator named, or all."""
    if options.run is None or str(options.run).casefold() == "all":
        return tables
    wanted = str(options.run).strip().lstrip("#").lstrip("0") or "0"
    found = [table for table in tables if table.run.casefold() == wanted.casefold()]
    if found:
        return found
    names = ", ".join(table.run for table in tables if table.run)
    raise problem(
        path,
        f"has no run '{options.run}'",
        f"it holds runs {names}" if names else "it holds one recording: leave --run out",
    )


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
        require_size(path, path.stat().st_size, MAX_BYTES)
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise problem(path, f"cannot be read ({reason})", "check the name and the permissions") from None
    if not data.strip(b"\0 \t\r\n"):
        raise problem(path, "is empty", "record again or name another file")
    return data
