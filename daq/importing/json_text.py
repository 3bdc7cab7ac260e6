"""JSON: rows, records, columns or channels under some key, or these for each run, with settings beside them."""

import json
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing.errors import LONGEST_NAME, MAX_NUMBERS, MAX_TEXT, problem, require_size, require_table
from daq.importing.numbers import parse_cell, parse_number, rate_of
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

FEWEST, MANY, MOST_MEMBERS, MOST_NAMED = 3, 8, 1000, 8
MOST_MEMORY = 600_000_000
BYTES_FOR = ((b"{", 250), (b"[", 100), (b",", 40), (b"", 5))
"""What Python keeps for an object, a list, a member, and each byte at most, bytes."""
DEEPEST_TABLE, DEEPEST = 5, 20
_UNITS = re.compile(r"(.*\S)[\s_-]+units?|units?[\s_-]+(?:of[\s_-]+)?(.*\S)", re.I)


Columns = list[tuple[str, Array]]
"""The columns of a table: the name of each ("" without), and its numbers."""


def is_json(data: bytes) -> bool:
    """Check whether the bytes begin as a JSON object or a list of rows."""
    head = data[:200].lstrip(b"\xef\xbb\xbf \t\r\n")
    return head[:1] == b"{" or bool(re.match(rb"\[\s*[\[{]", head))


def read_json(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the table in a JSON file: the largest, or that under the recipe's `property`.

    Settings beside it may name units (`displacement units`) and the rate or the step of time. Raises
    ImportProblem when there is no table, or the text is not JSON.
    """
    require_size(path, len(data), MAX_TEXT, " of JSON")
    if sum(cost * data.count(sign) for sign, cost in BYTES_FOR) > MOST_MEMORY:
        raise problem(
            path, f"has {len(data) / 1e6:.0f} MB in too many parts for 1 GB of memory", "cut it to the releases"
        )  # fmt: skip
    document = _document(path, data, recipe.encoding)
    wanted = recipe.dialect
    tables = dict(_tables_in(_way(document, wanted.property or "")[-1], wanted.property or "", 0))
    if not tables:
        raise problem(
            path, f"holds no table of numbers{f' under {wanted.property!r}' if wanted.property else ''}",
            'give rows, records or columns under one key, as {"data": [[0.0, 1.2], ...]}',
        )  # fmt: skip
    key, found = max(tables.items(), key=lambda table: len(table[1]) * len(table[1][0][1]))
    rows = len(found[0][1])
    require_table(path, rows, len(found))
    settings: dict[str, Any] = {}
    for node in _way(document, key):
        settings |= dict(_scalars(node))
    units = [(m, value) for name, value in settings.items() if (m := _UNITS.fullmatch(name))]
    unit_of = {(m[1] or m[2]).strip().casefold(): str(value).strip() for m, value in reversed(units)}
    columns = tuple(
        SourceColumn(i, name, values, unit_of.get(name.casefold(), ""))
        for i, (name, values) in enumerate(found, start=1)
    )
    notes = [f"JSON{f', key {key!r}' if key else ''}: {rows} rows, {len(columns)} columns"]
    others = [other for other in tables if other != key][:MOST_NAMED]
    notes += [f"not read: the table under {k!r}; property in a recipe's dialect names it" for k in others]
    used = wanted.model_copy(update={"property": key if 0 < len(key) <= LONGEST_NAME else None})
    return Table(
        path, columns, None, *rate_of(settings), tuple(notes), format="json", encoding=recipe.encoding, dialect=used
    )  # fmt: skip


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


def _tables_in(node: Any, path: str, depth: int) -> Iterator[tuple[str, Columns]]:
    """Yield the tables at and below a node by the path of keys, `a.2.b`; one that is a table itself holds no others."""
    if columns := _columns(node):
        yield path, columns
    elif depth < DEEPEST_TABLE:
        for name, value in _members(node):
            yield from _tables_in(value, f"{path}.{name}" if path else name, depth + 1)


def _columns(node: Any) -> Columns:
    """Return the columns of numbers of one length that a node itself holds, with their names; none where it is no table."""
    made = [(name, numbers) for name, cells in _cells(node) if (numbers := _numbers(cells)) is not None]
    lengths = Counter(len(values) for _, values in made)
    most = max(lengths, key=lambda n: (lengths[n], n), default=0)
    return [(name, values) for name, values in made if len(values) == most >= FEWEST]


def _cells(node: Any) -> list[tuple[str, Sequence[Any]]]:
    """Return the columns of an object of lists, or of a list: of records, of objects that each hold a name and one list, of
    rows, or of a few long lists, one a channel: nothing has eight times as many channels as samples.
    """
    if isinstance(node, dict):
        return [(str(name), value) for name, value in node.items() if isinstance(value, list)]
    if not isinstance(node, list) or not node:
        return []
    if all(isinstance(member, dict) for member in node):
        lists = [[value for value in member.values() if isinstance(value, list)] for member in node]
        said = [{str(key).lower(): value for key, value in member.items()} for member in node]
        labels = [one.get("name") or one.get("label") for one in said]
        if all(len(found) == 1 and label for found, label in zip(lists, labels, strict=True)):
            units = [one.get("unit") or one.get("units") for one in said]
            return [
                (f"{label} ({unit})" if unit else str(label), found[0])
                for label, unit, found in zip(labels, units, lists, strict=True)
            ]
        names = list(dict.fromkeys(str(name) for record in node for name in record))
        few = len(names) * len(node) <= MAX_NUMBERS
        return [(name, [record.get(name) for record in node]) for name in names] if few else []
    if not all(isinstance(row, list) for row in node):
        return []
    if all(len(row) == len(node[0]) > MANY * len(node) for row in node):
        return [("", row) for row in node]
    width = max(len(row) for row in node)
    if any(len(row) < width - 1 for row in node):
        return []
    named = len(node[0]) == width and all(isinstance(v, str) and parse_number(v) is None for v in node[0])
    rows = node[1:] if named else node
    cells = [[row[i] if i < len(row) else None for row in rows] for i in range(width)]
    return list(zip(map(str, node[0]) if named else [""] * width, cells, strict=True))


def _numbers(values: Sequence[Any]) -> Array | None:
    """Return a list of numbers, texts of numbers or nulls as an array, None for anything else."""
    made = []
    for value in values:
        if isinstance(value, str):
            value = parse_cell(value)
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
