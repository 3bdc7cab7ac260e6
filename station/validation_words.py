"""A library's refusal of a value in plain words, for the person who gave the value."""

import re
from typing import Any

from pydantic import ValidationError

from station.suggestions import did_you_mean

LONGEST = 200


def refusal(error: ValidationError, known: tuple[str, ...] = ()) -> str:
    """Find where a document or a setting is wrong and how: "specimen.mass_kg must be greater than 0 (it is -3)"."""
    first = error.errors(include_url=False)[0]
    entry = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        return one_line(f"{entry} is not known here{did_you_mean(str(first['loc'][-1]), known)}")
    words = re.sub(r"^\w+ should", "must", str(first["msg"]))
    words = re.split(r", unable to | or instance of ", words)[0].replace("be a valid", "be a")
    words = words.replace("Field required", "is missing")
    given = first.get("input")
    if words.startswith("must be") and isinstance(given, int | float | str):
        words += f" (it is {_plain(given)})"
    return one_line(f"{entry} {words}".strip())


def _plain(value: Any) -> Any:
    return f"{value:g}" if isinstance(value, float) else value


def one_line(text: str) -> str:
    """Write a text in one line that fits a message, however much of a file it quotes."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."
