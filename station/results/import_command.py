"""The command that would import a file which was refused: the options that were given, and those that are missing."""

import shlex
from pathlib import Path

from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from station.exits import UsageProblem


def typed(file: Path, options: ImportOptions, missing: tuple[str, ...]) -> str:
    """Return the command line `station import FILE ...` with the options given and those missing."""
    lacking = [shlex.split(option) for option in missing]
    named = {tuple(words[:1]) + tuple(w.split("=")[0] for w in words[1:] if "=" in w) for words in lacking}
    given = [words for words in _given(options) if _key(words) not in named]
    return shlex.join(["station", "import", str(file), *(w for words in (*given, *lacking) for w in words)])


def _key(words: list[str]) -> tuple[str, ...]:
    return (words[0], *(w.split("=")[0] for w in words[1:] if "=" in w))


def _given(options: ImportOptions) -> list[list[str]]:
    given = [["--column", f"{quantity}={column}"] for quantity, column in options.columns.items()]
    given += [["--unit", f"{quantity}={unit}"] for quantity, unit in options.units.items()]
    values = {
        "--rate": options.rate, "--run": options.run, "--from": options.start, "--to": options.stop,
        "--delimiter": {"\t": "tab", " ": "blank"}.get(options.delimiter or "", options.delimiter),
        "--decimal": options.decimal, "--encoding": options.encoding, "--skip-rows": options.skip_rows or None,
        "--angle-from": None if options.angle_from is None else ",".join(options.angle_from),
    }  # fmt: skip
    given += [
        [name, f"{v:g}" if isinstance(v, float) else str(v)] for name, v in values.items() if v is not None
    ]
    flags = {
        "--resample": options.resample,
        "--keep-derived": options.keep_derived,
        "--keep-offset": options.keep_offset,
    }
    return given + [[name] for name, wanted in flags.items() if wanted]


def explained(file: Path, options: ImportOptions, refusal: ImportProblem) -> UsageProblem | ImportProblem:
    """Return a refusal with the command to type, where the options that would settle it are known."""
    if not refusal.options:
        return refusal
    return UsageProblem(f"{refusal}. Type: {typed(file, options, refusal.options)}")
