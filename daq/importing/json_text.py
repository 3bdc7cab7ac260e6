"""JSON: rows, records or columns under some key, with settings beside them."""

import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from daq.importing.errors import problem
from daq.importing.json_tables import FEWEST, table_in
from daq.importing.limits import LONGEST_NAME, MAX_TEXT, require_size, require_table
from daq.importing.numbers import parse_number
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table

MOST_MEMORY = 600_000_000
BYTES_FOR = ((b"{", 250), (b"[", 100), (b",", 40), (b"", 5))
"""What Python keeps for an object, a list, a member, and each byte at most, bytes."""
DEEPEST = 20
_RATE = re.compile(
    r"(?:sampl\w*[\s_-]*)?(?:rate|freq\w*)(?:[\s_-]*\(?k?hz\)?)?|fs|fps|samplerate|abtastrate", re.I
)
_STEP = re.compile(
    r"dt|ts|(?:sampl\w*[\s_-]*|time[\s_-]*)(?:interval|period|step)(?:[\s_-]*\(?m?s\)?)?", re.I
)
_UNITS = re.compile(r"(.*\S)[\s_-]+units?|units?[\s_-]+(?:of[\s_-]+)?(.*\S)", re.I)
_NAMES = ("columns", "names", "header", "headers", "fields", "channels", "labels", "keys", "variables")


def is_json(data: bytes) -> bool:
    """Return whether the bytes begin as a JSON object or a list of rows."""
    head = data[:200].lstrip(b"\xef\xbb\xbf \t\r\n")
    return head[:1] == b"{" or bool(re.match(rb"\[\s*[\[{]", head))


def read_json(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the table in a JSON file.

    The table is a list of rows, records or channels, an object of columns, or several of these for as many runs, at
    the top or under any key, or a record a line; settings
    beside it may name the columns, their units (`displacement units`) and the rate or the step of time. Raises
    ImportProblem when there is no table, or the text is not JSON.
    """
    require_size(path, len(data), MAX_TEXT, " of JSON")
    if sum(cost * data.count(sign) for sign, cost in BYTES_FOR) > MOST_MEMORY:
        raise problem(
            path,
            f"has {len(data) / 1e6:.0f} MB in too many parts for 1 GB of memory",
            "cut it to the releases",
        )
    document = _document(path, data, recipe.encoding)
    found = table_in(document)
    if found is None:
        raise problem(
            path,
            "holds no table of numbers",
            'give rows, records or columns under one key, as {"data": [[0.0, 1.2], ...]}',
        )
    key, names, columns, beside = found
    require_table(path, len(columns[0]), len(columns))
    settings = {**_scalars(document), **_scalars(beside)}
    notes = [f"JSON{f', key {key!r}' if key else ''}: {len(columns[0])} rows, {len(columns)} columns"]
    units = _units(settings)
    names = names or _said_names(document, beside, len(columns)) or [""] * len(columns)
    unit_of = {what.casefold(): unit for what, unit in reversed(units.items())}
    made = tuple(
        SourceColumn(i + 1, name, values, unit_of.get(name.casefold(), ""))
        for i, (name, values) in enumerate(zip(names, columns, strict=True))
    )
    rate, source = _rate(settings)
    return Table(path, made, None, rate, source, tuple(notes), format="json", encoding=recipe.encoding)


def _document(path: Path, data: bytes, encoding: str | None) -> Any:
    """Return what a JSON text holds, or the list of what its lines hold where each line is one."""
    try:
        text = data.decode(encoding or "utf-8-sig")
        try:
            return json.loads(text)
        except ValueError:
            lines = [line for line in text.splitlines() if line.strip()]
            if len(lines) < FEWEST or not all(line.lstrip()[0] in "{[" for line in lines):
                raise
            return [json.loads(line) for line in lines]
    except (ValueError, LookupError, RecursionError) as error:
        line = getattr(error, "lineno", None)
        raise problem(
            path, f"begins as JSON, but cannot be read ({error})", "export it again", line=line
        ) from None


def _scalars(node: Any, depth: int = 0) -> dict[str, Any]:
    """Return what an object says beside its table, its inner objects included."""
    if not isinstance(node, dict) or depth > DEEPEST:
        return {}
    found: dict[str, Any] = {}
    for name, value in node.items():
        if isinstance(value, dict):
            inner = _scalars(value, depth + 1)
            found |= {
                f"{k} units" if str(name).lower() in ("unit", "units") else k: v for k, v in inner.items()
            }
        elif isinstance(value, int | float | str):
            found[str(name)[:LONGEST_NAME]] = value
    return found


def _said_names(document: Any, beside: Any, width: int) -> list[str] | None:
    for node in (beside, document):
        if isinstance(node, dict):
            for name, value in node.items():
                names = str(name).lower() in _NAMES and isinstance(value, list) and len(value) == width
                if names and all(isinstance(v, str) for v in value):
                    return [str(v) for v in value]
    return None


def _units(settings: Mapping[str, Any]) -> dict[str, str]:
    """Return the units that the settings state, by what they state them of, in their order."""
    found = {}
    for name, value in settings.items():
        match = _UNITS.fullmatch(name)
        if match and isinstance(value, str):
            found[(match[1] or match[2]).strip()] = value.strip()
    return found


def _rate(settings: Mapping[str, Any]) -> tuple[float | None, str]:
    for name, value in settings.items():
        number = parse_number(value) if isinstance(value, str) else value
        if not isinstance(number, int | float) or isinstance(number, bool) or not 0.0 < number < 1e9:
            continue
        if _RATE.fullmatch(name.strip()):
            return float(number) * (1e3 if "khz" in name.lower() else 1.0), f"'{name}'"
        if _STEP.fullmatch(name.strip()):
            return 1.0 / (float(number) * (1e-3 if "ms" in name.lower() else 1.0)), f"'{name}'"
    return None, ""
