"""The error of an import: one sentence that says where the file is wrong, and what to do."""

from pathlib import Path

from daq.errors import OperatorError


class ImportProblem(OperatorError):
    """A file that cannot be imported as it stands, or an option that does not fit it (exit code 2)."""


def problem(
    path: Path, what: str, todo: str = "", *, line: int | None = None, column: int | None = None
) -> ImportProblem:
    """Return the error whose sentence gives file, line, column, what is wrong and what to do."""
    return ImportProblem(f"{place(path, line, column)}: {what}" + (f"; {todo}" if todo else ""))


def place(path: Path, line: int | None, column: int | None) -> str:
    """Name a place in a file, as the beginning of a sentence."""
    numbers = f", line {line}" if line is not None else ""
    return path.name + numbers + (f", column {column}" if column is not None else "")
