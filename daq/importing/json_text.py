"""JSON: rows, records, columns or channels under some key, or these for each run, with settings beside them."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing.errors import problem
from daq.importing.limits import LONGEST_NAME, MAX_NUMBERS, MAX_TEXT, require_size, require_table
from daq.importing.numbers import parse_clock, parse_number
from daq.importing.rates import rate_of
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

FEWEST, MANY, MOST_MEMBERS = 3, 8, 1000
MOST_MEMORY = 600_000_000
BYTES_FOR = ((b"{", 250), (b"[", 100), (b",", 40), (b"", 5))
"""What Python keeps for an object, a list, a member, and each byte at most, bytes."""
DEEPEST_TABLE, DEEPEST = 5, 20
_UNITS = re.compile(r"(.*\S)[\s_-]+units?|units?[\s_-]+(?:of[\s_-]+)?(.*\S)", re.I)
_NAMES = ("columns", "names", "header", "headers", "fields", "channels", "labels", "keys", "variables")


@dataclass(frozen=True, eq=False)
class _Found:
    """A table: the path of keys it stands under, `a.2.b`, the names of its columns ("" without), their numbers."""

    path: str
    names: tuple[str, ...]
    columns: tuple[Array, ...]

    @property
    def size(self) -> int:
        return len(self.columns[0]) * len(self.columns)


def is_json(data: bytes) -> bool:
    """Check whether the bytes begin as a JSON object or a list of rows."""
    head = data[:200].lstrip(b"\xef\xbb\xbf \t\r\n")
    return head[:1] == b"{" or bool(re.match(rb"\[\s*[\[{]", head))


def read_json(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the table in a JSON file: the largest, or that under the recipe's `property`, with its `itemKeys` as columns.

    Settings beside it may name the columns, their units (`displacement units`) and the rate or the step of time. Raises
    ImportProblem when there is no table, or the text is not JSON.
    """
    require_size(path, len(data), MAX_TEXT, " of JSON")
    if sum(cost * data.count(sign) for sign, cost in BYTES_FOR) > MOST_MEMORY:
        raise problem(
            path, f"has {len(data) / 1e6:.0f} MB in too many parts for 1 GB of memory", "cut it to the releases"
        )  # fmt: skip
    document = _document(path, data, recipe.encoding)
    wanted = recipe.dialect
    found = _table_in(_way(document, wanted.property or "")[-1], wanted.property or "", 0)
    if found is None:
        raise problem(
            path, f"holds no table of numbers{f' under {wanted.property!r}' if wanted.property else ''}",
            'give rows, records or columns under one key, as {"data": [[0.0, 1.2], ...]}',
        )  # fmt: skip
    require_table(path, len(found.columns[0]), len(found.columns))
    settings: dict[str, Any] = {}
    names = found.names
    for node in _way(document, found.path):
        settings |= dict(_scalars(node))
        names = names if any(names) else _said_names(node, len(names)) or names
    units = [(m, value) for name, value in settings.items() if (m := _UNITS.fullmatch(name))]
    unit_of = {(m[1] or m[2]).strip().casefold(): str(value).strip() for m, value in reversed(units)}
    made = [
        SourceColumn(i, name, values, unit_of.get(name.casefold(), ""))
        for i, (name, values) in enumerate(zip(names, found.columns, strict=True), start=1)
    ]
    if wanted.item_keys:
        made = [column for name in wanted.item_keys for column in made if column.label == name]
    note = f"JSON{f', key {found.path!r}' if found.path else ''}: {len(found.columns[0])} rows, {len(made)} columns"
    used = wanted.model_copy(update={"property": found.path if 0 < len(found.path) <= LONGEST_NAME else None})
    rate, source = rate_of(settings)
    return Table(
        path, tuple(made), None, rate, source, (note,), format="json", encoding=recipe.encoding, dialect=used
    )


def _document(path: Path, data: bytes, encoding: str | None) -> Any:
    """Parse a JSON text; where each line is one, a list of them."""
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


def _way(node: Any, path: str) -> list[Any]:
    """List the nodes from this one to that under a path, None last where there is none; a key may have points in it."""
    if not path:
        return [node]
    inner = dict(_members(node))
    key = max((name for name in inner if f"{path}.".startswith(f"{name}.")), key=len, default=None)
    return [node, *(_way(inner[key], path[len(key) + 1 :]) if key is not None else [None])]


def _members(node: Any) -> list[tuple[str, Any]]:
    if isinstance(node, dict):
        return [(str(name), value) for name, value in node.items()]
    return (
        [(str(i), value) for i, value in enumerate(node[:MOST_MEMBERS], 1)] if isinstance(node, list) else []
    )


def _table_in(node: Any, path: str, depth: int) -> _Found | None:
    """Return the largest table at or below a node, None when there is none.

    Several members that hold tables with the same names of columns are runs: their columns stand side by side, `x Run 2`.
    """
    columns = _columns(node)
    if columns:
        return _Found(path, tuple(name for name, _ in columns), tuple(values for _, values in columns))
    if depth >= DEEPEST_TABLE:
        return None
    inner = [
        (name, found)
        for name, value in _members(node)
        if isinstance(value, dict | list)
        and (found := _table_in(value, f"{path}.{name}" if path else name, depth + 1))
    ]
    runs = [(name, found) for name, found in inner if any(found.names) and len(found.columns) > 1]
    longest = max((len(found.columns[0]) for _, found in runs), default=0)
    alike = len(runs) > 1 and all(found.names == runs[0][1].names for _, found in runs)
    if not alike or longest * len(runs) * len(runs[0][1].names) > MAX_NUMBERS:
        return max((found for _, found in inner), key=lambda found: found.size, default=None)
    numbers = [match[1] if (match := re.search(r"(\d{1,4})$", name[-4:])) else "" for name, _ in runs]
    if "" in numbers or len(set(numbers)) < len(numbers):
        numbers = [str(i) for i in range(1, len(runs) + 1)]
    made = [
        (f"{name} Run {number}", np.pad(values, (0, longest - len(values)), constant_values=np.nan))
        for number, (_, found) in zip(numbers, runs, strict=True)
        for name, values in zip(found.names, found.columns, strict=True)
    ]
    return _Found(path, tuple(name for name, _ in made), tuple(values for _, values in made))


def _columns(node: Any) -> list[tuple[str, Array]]:
    """Return the columns that a node itself holds, with their names; none where it is no table.

    It may be an object of columns, or a list: of records, of objects that each hold a name and one list, of rows, or of a
    few long lists, one a channel: nothing has eight times as many channels as samples.
    """
    if isinstance(node, dict):
        made = [
            (k, v)
            for name, value in node.items()
            if isinstance(value, list)
            for k, v in [(str(name), _numbers(value))]
        ]
        lengths = Counter(len(values) for _, values in made if values is not None)
        most = max(lengths, key=lambda n: (lengths[n], n), default=0)
        return [(k, v) for k, v in made if v is not None and len(v) == most] if most >= FEWEST else []
    if not isinstance(node, list) or not node:
        return []
    if all(isinstance(member, dict) for member in node):
        return _channels(node) or _records(node)
    if not all(isinstance(row, list) for row in node):
        return []
    if all(len(row) == len(node[0]) > MANY * len(node) for row in node):
        return _all_numbers([("", row) for row in node])
    width = max(len(row) for row in node)
    if len(node) < FEWEST or not width or any(len(row) < width - 1 for row in node):
        return []
    named = all(isinstance(cell, str) and parse_number(cell) is None for cell in node[0])
    names = [str(cell) for cell in node[0]] if named and len(node[0]) == width else [""] * width
    rows = node[1:] if named else node
    return _all_numbers(
        [(names[i], [row[i] if i < len(row) else None for row in rows]) for i in range(width)]
    )


def _all_numbers(columns: Sequence[tuple[str, Sequence[Any]]]) -> list[tuple[str, Array]]:
    made = [(name, numbers) for name, cells in columns if (numbers := _numbers(cells)) is not None]
    return made if len(made) == len(columns) else []


def _channels(node: Sequence[Mapping[str, Any]]) -> list[tuple[str, Array]]:
    made = []
    for member in node:
        texts = {str(k).lower(): v for k, v in member.items() if isinstance(v, str)}
        name = next(
            (texts[k] for k in ("name", "label", "channel", "title", "quantity", "id") if k in texts), ""
        )
        unit = texts.get("unit") or texts.get("units")
        lists = [found for v in member.values() if isinstance(v, list) and (found := _numbers(v)) is not None]
        if not name or len(lists) != 1 or len(lists[0]) < FEWEST:
            return []
        made.append((f"{name} ({unit})" if unit else name, lists[0]))
    return made if len({len(values) for _, values in made}) == 1 else []


def _records(node: Sequence[Mapping[str, Any]]) -> list[tuple[str, Array]]:
    names = list(dict.fromkeys(str(name) for record in node for name in record))
    if len(node) < FEWEST or len(names) * len(node) > MAX_NUMBERS:
        return []
    made = [(name, _numbers([record.get(name) for record in node])) for name in names]
    return [(name, values) for name, values in made if values is not None]


def _numbers(values: Sequence[Any]) -> Array | None:
    """Return a list of numbers, texts of numbers or nulls as an array, None for anything else."""
    made = []
    for value in values:
        if isinstance(value, str):
            number = parse_number(value)
            value = parse_clock(value) if number is None else number
            if value is None:
                return None
        elif isinstance(value, bool) or not isinstance(value, int | float | None):
            return None
        made.append(float(value) if value is not None and abs(value) < 1e308 else np.nan)
    return np.array(made) if made else None


def _scalars(node: Any, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield what an object says beside its table, its inner objects included."""
    if not isinstance(node, dict) or depth > DEEPEST:
        return
    for name, value in node.items():
        if isinstance(value, dict):
            of_units = " units" if str(name).lower() in ("unit", "units") else ""
            yield from ((f"{k}{of_units}", v) for k, v in _scalars(value, depth + 1))
        elif isinstance(value, int | float | str):
            yield str(name)[:LONGEST_NAME], value


def _said_names(node: Any, width: int) -> tuple[str, ...] | None:
    for name, value in node.items() if isinstance(node, dict) else ():
        fits = str(name).lower() in _NAMES and isinstance(value, list) and len(value) == width
        if fits and all(isinstance(v, str) for v in value):
            return tuple(value)
    return None
