"""What is said of a mistyped word, a value that a library refuses, or a file that cannot be read, to who gave it."""

import difflib
import re
from collections.abc import Iterable
from pathlib import Path

from pydantic import ValidationError

from station.exits import UsageProblem

MEASURED_CURVE = "measured_curve"
"""What is added to a model where no effect of the library fits: the measured curve of the residual."""

_CLOSE = 0.5
_MOST = 3
_SHORTEST = 4
LONGEST = 200
LARGEST = 1 << 20


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return "; did you mean 'stribeck_friction'?" for a mistyped word, with the nearest names first; "" without any."""
    names = {name.lower(): name for name in known}
    typed = word.lower().strip()
    whole = [name for name in names if typed in name and len(typed) >= _SHORTEST]
    found = whole[:_MOST] or difflib.get_close_matches(typed, names, _MOST, _CLOSE)
    return f"; did you mean {' or '.join(repr(names[name]) for name in found)}?" if found else ""


def read_named(path: Path, what: str, most: int = LARGEST) -> bytes:
    """Return what is in a file that the operator named; UsageProblem, which says `what` it is, where it cannot be read.

    So is one of more than `most` bytes.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(most + 1)
    except OSError as error:
        raise UsageProblem(f"{what} {path} cannot be read: {error.strerror or error}") from error
    if len(content) > most:
        raise UsageProblem(f"{what} {path}: larger than {most >> 20} MB; name another file")
    return content


def refusal(error: ValidationError, known: tuple[str, ...] = ()) -> str:
    """Find where a document or a setting is wrong and how: "specimen.mass_kg must be greater than 0 (it is -3)"."""
    first = error.errors(include_url=False)[0]
    entry = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        return shortened(f"{entry} is not known here{did_you_mean(str(first['loc'][-1]), known)}")
    words = re.sub(r"^\w+ should", "must", str(first["msg"]))
    words = re.split(r", unable to | or instance of ", words)[0].replace("be a valid", "be a")
    words = words.replace("Field required", "is missing")
    given = first.get("input")
    if words.startswith("must be") and isinstance(given, int | float | str):
        words += f" (it is {given:g})" if isinstance(given, float) else f" (it is {given})"
    return shortened(f"{entry} {words}".strip())


def shortened(text: str) -> str:
    """Write a text in one line that fits a message, however much of a file it quotes."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."
