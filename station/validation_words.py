"""What a library's refusal of a value means, in a clause for the person who gave it."""

from typing import Any

from pydantic import ValidationError

from station.suggestions import did_you_mean

LONGEST = 200

_WORDS = {
    "greater_than": "must be above {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be below {lt}",
    "less_than_equal": "must be at most {le}",
    "finite_number": "must be a finite number",
    "string_too_long": "has more than {max_length} characters",
    "too_long": "has more than {max_length} entries",
    "too_short": "has fewer than {min_length} entries",
    "missing": "is missing",
    "string_type": "must be a text",
    "bool_type": "must be true or false",
    "literal_error": "must be {expected}",
    "json_invalid": "is not JSON ({error})",
}
_KINDS = (("float", "must be a number"), ("int", "must be a whole number"), ("tuple", "must be a list"),
          ("list", "must be a list"), ("dict", "must be a table"), ("model", "must be a table"),
          ("path", "must be a path"))  # fmt: skip


def refusal(error: ValidationError, known: tuple[str, ...] = ()) -> str:
    """Find where a document or a setting is wrong and how: "specimen.mass_kg must be above 0 (it is -3)"."""
    first = error.errors(include_url=False)[0]
    entry = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden":
        return one_line(f"{entry} is not known here{did_you_mean(str(first['loc'][-1]), known)}")
    given = first.get("input")
    shown = f" (it is {_plain(given)})" if isinstance(given, int | float | str) else ""
    if first["type"] in ("missing", "json_invalid", "string_too_long"):
        shown = ""
    words = f"{_clause(str(first['type']), first.get('ctx', {}), str(first['msg']))}{shown}"
    return one_line(f"{entry} {words}" if entry else f"the text {words}")


def _clause(kind: str, context: dict[str, Any], message: str) -> str:
    if kind in _WORDS:
        return _WORDS[kind].format(**{name: _plain(value) for name, value in context.items()})
    for start, words in _KINDS:
        if kind.startswith(start):
            return words
    return f"cannot be used ({message[:1].lower()}{message[1:]})"


def _plain(value: Any) -> Any:
    return f"{value:g}" if isinstance(value, float) else value


def one_line(text: str) -> str:
    """Write a text in one line that fits a message, however much of a file it quotes."""
    line = " ".join(text.split())
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."
