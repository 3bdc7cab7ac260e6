"""Where the table is in a JSON document: rows, records, columns, channels, or a table for each run."""

import re
from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from daq.importing.limits import MAX_NUMBERS
from daq.importing.numbers import parse_clock, parse_number
from daq.recording import Array

FEWEST = 3
MANY = 8
DEEPEST = 5
_LABELS = ("name", "label", "channel", "title", "quantity", "id")
_UNITS = ("unit", "units")


class Found(NamedTuple):
    """A table: the key it stands under, the names of its columns (None without), their numbers, the object beside."""

    key: str
    names: list[str] | None
    columns: list[Array]
    beside: Any


def table_in(node: Any, key: str = "", depth: int = 0) -> Found | None:
    """Return the largest table at or below a node of a JSON document, None when there is none.

    Several objects that hold tables with the same columns are runs: their columns stand side by side, `x Run 2`.
    """
    if depth > DEEPEST:
        return None
    if isinstance(node, list):
        return (
            _from_list(node, key)
            or _from_channels(node, key)
            or _from_runs(list(zip(map(str, range(1, 1001)), node, strict=False)), key, depth)
        )
    if not isinstance(node, dict):
        return None
    columns = {
        str(name): values
        for name, value in node.items()
        if isinstance(value, list) and (values := _numbers(value)) is not None
    }
    lengths = Counter(len(values) for values in columns.values())
    if lengths:
        most = max(lengths, key=lambda n: (lengths[n], n))
        columns = {name: values for name, values in columns.items() if len(values) == most}
        if most >= FEWEST:
            return Found(key, list(columns), list(columns.values()), node)
    runs = _from_runs([(str(k), v) for k, v in node.items() if isinstance(v, dict | list)], key, depth)
    if runs is not None:
        return runs
    inner = [found for name, value in node.items() if (found := table_in(value, str(name), depth + 1))]
    best = max(inner, key=lambda found: len(found.columns[0]) * len(found.columns), default=None)
    return None if best is None else best._replace(beside=best.beside or node)


def _from_runs(members: Sequence[tuple[str, Any]], key: str, depth: int) -> Found | None:
    tables = [
        (name, found)
        for name, node in members
        if isinstance(node, dict | list) and (found := table_in(node, name, depth + 1))
    ]
    tables = [(name, found) for name, found in tables if found.names is not None and len(found.columns) > 1]
    if len(tables) < 2 or any(found.names != tables[0][1].names for _, found in tables):
        return None
    longest = max(len(found.columns[0]) for _, found in tables)
    if longest * len(tables) * len(tables[0][1].columns) > MAX_NUMBERS:
        return None
    numbers = [match[1] if (match := re.search(r"(\d{1,4})$", name[-4:])) else "" for name, _ in tables]
    if "" in numbers or len(set(numbers)) < len(numbers):
        numbers = [str(i) for i in range(1, len(tables) + 1)]
    names, columns = [], []
    for number, (_, found) in zip(numbers, tables, strict=True):
        for name, values in zip(found.names or [], found.columns, strict=True):
            names.append(f"{name} Run {number}")
            columns.append(np.concatenate((values, np.full(longest - len(values), np.nan))))
    return Found(key, names, columns, tables[0][1].beside)


def _from_channels(node: list[Any], key: str) -> Found | None:
    """Read a list of objects that each hold a name and the numbers of one channel."""
    names, columns = [], []
    for member in node:
        if not isinstance(member, dict):
            return None
        name = next((str(member[k]) for k in _LABELS if isinstance(member.get(k), str)), "")
        unit = next((str(member[k]) for k in _UNITS if isinstance(member.get(k), str)), "")
        lists = [
            values for v in member.values() if isinstance(v, list) and (values := _numbers(v)) is not None
        ]
        if not name or len(lists) != 1 or len(lists[0]) < FEWEST:
            return None
        names.append(f"{name} ({unit})" if unit else name)
        columns.append(lists[0])
    if not columns or len({len(values) for values in columns}) > 1:
        return None
    return Found(key, names, columns, None)


def _from_lists_of_channels(node: list[Any], key: str) -> Found | None:
    """Read a few long lists, one for each channel: nothing has eight times as many channels as samples."""
    if not node or not all(isinstance(row, list) and len(row) > MANY * len(node) for row in node):
        return None
    columns = [_numbers(row) for row in node]
    if any(c is None for c in columns) or len({len(row) for row in node}) > 1:
        return None
    return Found(key, None, [c for c in columns if c is not None], None)


def _from_list(node: list[Any], key: str) -> Found | None:
    channels = _from_lists_of_channels(node, key)
    if channels is not None:
        return channels
    if len(node) < FEWEST:
        return None
    if all(isinstance(row, dict) for row in node):
        return _from_records(node, key)
    if not all(isinstance(row, list) for row in node):
        return None
    names: list[str] | None = None
    rows: list[list[Any]] = node
    if rows[0] and all(isinstance(cell, str) and parse_number(cell) is None for cell in rows[0]):
        names, rows = [str(cell) for cell in rows[0]], rows[1:]
    width = max(len(row) for row in rows)
    if not width or any(len(row) < width - 1 for row in rows):
        return None
    columns = [_numbers([row[i] if i < len(row) else None for row in rows]) for i in range(width)]
    if any(column is None for column in columns):
        return None
    said = names if names is not None and len(names) == width else None
    return Found(key, said, [c for c in columns if c is not None], None)


def _from_records(node: list[dict[str, Any]], key: str) -> Found | None:
    names = list(dict.fromkeys(str(name) for record in node for name in record))
    if len(names) * len(node) > MAX_NUMBERS:
        return None
    cells = [_numbers([record.get(name) for record in node]) for name in names]
    kept = [(n, c) for n, c in zip(names, cells, strict=True) if c is not None]
    return Found(key, [n for n, _ in kept], [c for _, c in kept], None) if kept else None


def _numbers(values: Sequence[Any]) -> Array | None:
    """Return a list of numbers, texts of numbers or nulls as an array, None for anything else."""
    made = []
    for value in values:
        if value is None:
            made.append(np.nan)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            made.append(float(value) if abs(value) < 1e308 else np.nan)
        elif isinstance(value, str):
            number = parse_number(value)
            number = parse_clock(value) if number is None else number
            if number is None:
                return None
            made.append(number)
        else:
            return None
    return np.array(made) if made else None
