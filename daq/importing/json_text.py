"""JSON: rows, records or columns under some key, with settings beside them."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing.columns import meaning
from daq.importing.errors import problem
from daq.importing.numbers import parse_clock, parse_number
from daq.importing.options import ImportOptions
from daq.importing.runs import rises_evenly
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

FEWEST = 3
MAX_COLUMNS = 2000
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


def read_json(path: Path, data: bytes, options: ImportOptions) -> Table:
    """Return the table in a JSON file.

    The table is a list of rows, a list of records, or an object of columns, at the top or under any key; settings
    beside it may name the columns, their units (`displacement units`) and the rate or the step of time. Raises
    ImportProblem when there is no table, or the text is not JSON.
    """
    try:
        document = json.loads(data.decode(options.encoding or "utf-8-sig"))
    except (ValueError, LookupError, RecursionError) as error:
        line = getattr(error, "lineno", None)
        raise problem(
            path, f"begins as JSON, but cannot be read ({error})", "export it again", line=line
        ) from None
    found = _table_in(document, "")
    if found is None:
        raise problem(
            path,
            "holds no table of numbers",
            'give rows, records or columns under one key, as {"data": [[0.0, 1.2], ...]}',
        )
    key, names, columns, beside = found
    if len(columns) > MAX_COLUMNS:
        raise problem(path, f"has {len(columns)} columns, more than {MAX_COLUMNS}", "write one row a sample")
    settings = {**_scalars(document), **_scalars(beside)}
    notes = [f"JSON{f', key {key!r}' if key else ''}: {len(columns[0])} rows, {len(columns)} columns"]
    units = _units(settings)
    names = names or _said_names(document, beside, len(columns))
    if names is None:
        names = _by_units(columns, units, notes)
    made = tuple(
        SourceColumn(i + 1, name, values, _unit_of(name, units))
        for i, (name, values) in enumerate(zip(names, columns, strict=True))
    )
    rate, source = _rate(settings)
    return Table(path, made, None, rate, source, tuple(notes))


Found = tuple[str, list[str] | None, list[Array], Any]


def _table_in(node: Any, key: str, depth: int = 0) -> Found | None:
    """Return key, names, columns and the object beside the largest table below a node."""
    if depth > 4:
        return None
    if isinstance(node, list):
        return _from_list(node, key)
    if not isinstance(node, dict):
        return None
    columns = {
        str(name): values
        for name, value in node.items()
        if isinstance(value, list) and (values := _numbers(value)) is not None
    }
    lengths = [len(values) for values in columns.values()]
    if lengths:
        most = max(set(lengths), key=lambda n: (lengths.count(n), n))
        columns = {name: values for name, values in columns.items() if len(values) == most}
        if most >= FEWEST:
            return key, list(columns), list(columns.values()), node
    inner = [found for name, value in node.items() if (found := _table_in(value, str(name), depth + 1))]
    best = max(inner, key=lambda found: len(found[2][0]) * len(found[2]), default=None)
    return None if best is None else (*best[:3], best[3] or node)


def _from_list(node: list[Any], key: str) -> Found | None:
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
    return key, said, [c for c in columns if c is not None], None


def _from_records(node: list[dict[str, Any]], key: str) -> Found | None:
    names = list(dict.fromkeys(str(name) for record in node for name in record))
    cells = [_numbers([record.get(name) for record in node]) for name in names]
    kept = [(n, c) for n, c in zip(names, cells, strict=True) if c is not None]
    return (key, [n for n, _ in kept], [c for _, c in kept], None) if kept else None


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


def _scalars(node: Any) -> dict[str, Any]:
    """Return what an object says beside its table, its inner objects included."""
    if not isinstance(node, dict):
        return {}
    found: dict[str, Any] = {}
    for name, value in node.items():
        if isinstance(value, dict):
            inner = _scalars(value)
            found |= {
                f"{k} units" if str(name).lower() in ("unit", "units") else k: v for k, v in inner.items()
            }
        elif isinstance(value, int | float | str):
            found[str(name)] = value
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


def _unit_of(name: str, units: Mapping[str, str]) -> str:
    return next((unit for what, unit in units.items() if what.casefold() == name.casefold()), "")


def _by_units(columns: Sequence[Array], units: Mapping[str, str], notes: list[str]) -> list[str]:
    """Name columns that have no names after the units that the file states: time, then one motion, the forces last."""
    names = [""] * len(columns)
    kinds = {what: meaning(what).quantity for what in units}
    motions = [what for what, kind in kinds.items() if kind in ("displacement", "velocity", "acceleration")]
    forces = [what for what, kind in kinds.items() if kind == "force"]
    timed = rises_evenly(SourceColumn(1, "", columns[0]))
    if len(motions) != 1 or not timed or len(columns) < 2 + len(forces):
        return names
    names[0] = next((what for what, kind in kinds.items() if kind == "time"), "time")
    names[1] = motions[0]
    names[len(names) - len(forces) :] = forces
    said = ", ".join(f"column {i + 1} '{name}'" for i, name in enumerate(names) if name)
    notes.append(
        f"the columns have no names; after the units that the file states they were taken as {said} "
        "(change it with --column displacement=...)"
    )
    return names


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
