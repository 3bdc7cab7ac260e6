"""What an import refuses: one sentence that says where the file is wrong, and what to do.

How large a file may be is checked before the memory is asked for, which stays under 1 GB. No pattern that searches backwards
meets a text longer than LONGEST_NAME.
"""

from pathlib import Path

from daq.errors import OperatorError

MAX_BYTES = 200_000_000
MAX_TEXT = 100_000_000
MAX_LINES = 1_500_000
MAX_RECIPE = 1_000_000
MAX_NUMBERS = 20_000_000
MAX_COLUMNS = 2000
MAX_SENTENCES = 1_000_000
"""Lines with words between the numbers."""
LONGEST_LINE = 200_000
LONGEST_NAME = 120


class ImportProblem(OperatorError):
    """A file that cannot be imported as it stands, or an option that does not fit it (exit code 2)."""


def problem(
    path: Path, what: str, todo: str, *, line: int | None = None, column: int | None = None
) -> ImportProblem:
    """Return the error whose sentence gives file, line, column, what is wrong and what to do."""
    return ImportProblem(f"{place(path, line, column)}: {what}; {todo}")


def place(path: Path, line: int | None, column: int | None) -> str:
    """Name a place in a file, as the beginning of a sentence."""
    numbers = f", line {line}" if line is not None else ""
    return path.name + numbers + (f", column {column}" if column is not None else "")


def require_size(path: Path, size: int, most: int, what: str = "") -> None:
    """Raise ImportProblem for a file of more than `most` bytes."""
    if size > most:
        raise problem(
            path, f"has {size / 1e6:.0f} MB, more than the {most / 1e6:.0f} MB{what} that are read", "cut it to the releases"
        )  # fmt: skip


def require_few(
    path: Path,
    count: int,
    most: int,
    what: str,
    todo: str = "cut it to the releases",
    line: int | None = None,
) -> None:
    """Raise ImportProblem for more than `most` of something."""
    if count > most:
        raise problem(path, f"has {count} {what}, more than {most}", todo, line=line)


def require_table(path: Path, rows: int, width: int) -> None:
    """Raise ImportProblem for a table of too many columns or numbers."""
    require_few(path, width, MAX_COLUMNS, "columns", "write one sample per line, one channel per column")
    require_few(path, rows * width, MAX_NUMBERS, "numbers")
