"""The error of an import: one sentence that says where the file is wrong, and what to do."""

from pathlib import Path

from daq.errors import UnreadableFile


class ImportProblem(UnreadableFile):
    """A file that cannot be imported as it stands, or an option that does not fit it (exit code 2).

    `options` are those that would settle it, as the command line writes them, where some are known.
    """

    options: tuple[str, ...] = ()


def problem(
    path: Path,
    what: str,
    todo: str = "",
    *,
    line: int | None = None,
    column: int | None = None,
    options: tuple[str, ...] = (),
) -> ImportProblem:
    """Return the error whose sentence gives file, line, column, what is wrong and what to do; `options` would settle it."""
    where = path.name
    if line is not None:
        where += f", line {line}"
    if column is not None:
        where += f", column {column}"
    made = ImportProblem(f"{where}: {what}" + (f"; {todo}" if todo else ""))
    made.options = options
    return made
