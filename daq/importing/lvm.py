"""LabVIEW's measurement files: settings in two headers, each closed by a line of its own, then names and numbers.

National Instruments, *Specification for the LabVIEW Measurement File (.lvm)*, version 2. Of several segments the first is
read.
"""

from collections.abc import Sequence
from pathlib import Path

from daq.importing.limits import MAX_CELLS, require_few
from daq.importing.numbers import parse_number
from daq.importing.recipe import Format

FIRST_LINE = "labview measurement"
CLOSED = "***end_of_header***"
X_VALUE = "X_Value"


def table_of(path: Path, lines: Sequence[str]) -> tuple[Format, list[str], str] | None:
    """Return the lines as a table between tabs with a header in its place, and a sentence on it; else None.

    Units come from `Y_Unit_Label`; where no time is written (`X_Columns No`), from `X0` and `Delta_X` it is.
    """
    if not lines or not lines[0].lstrip("\ufeff").strip().casefold().startswith(FIRST_LINE):
        return None
    require_few(path, max(sum(line.count(sign) for line in lines) for sign in "\t,"), MAX_CELLS, "cells")
    closed = [i for i, line in enumerate(lines) if line.strip().casefold().startswith(CLOSED)]
    start = (
        next((i for i in range(closed[1] + 1, len(lines)) if lines[i].strip()), 0) if len(closed) > 1 else 0
    )
    if not start:
        return None
    by_comma = _first(_settings(lines[: closed[0]], ","), "separator", "tab").casefold() == "comma"
    separator = "," if by_comma else "\t"
    of_file, of_channels = (
        _settings(part, separator) for part in (lines[: closed[0]], lines[closed[0] + 1 : closed[1]])
    )
    names = [cell.strip() for cell in lines[start].split(separator)]
    width = names.index("Comment") if "Comment" in names else len(names)
    timed = _first(of_file, "x_columns", "One").casefold()
    point = _first(of_file, "decimal_separator", ".")
    end = next(
        (i for i in range(start + 1, len(lines)) if lines[i].casefold().startswith("channels")), len(lines)
    )
    body = [[cell.strip() for cell in line.split(separator)[:width]] for line in lines[start + 1 : end]]
    rows = [cells for cells in body if any(cells)]
    if timed == "no":
        first = parse_number(_first(of_channels, "x0", "0"), point) or 0.0
        step = parse_number(_first(of_channels, "delta_x", ""), point)
        if step is None or names[0] != X_VALUE:
            return None
        rows = [[f"{first + i * step:.12g}", *cells[1:]] for i, cells in enumerate(rows)]
        rows = [[cell.replace(",", ".") for cell in cells] for cells in rows]
    header = _header(names[:width], of_channels, timed)
    said = "a measurement file of LabVIEW was read by its headers"
    if len(closed) > 2:
        said += "; of its segments the first"
    return "labview", [*[""] * start, "\t".join(header), *("\t".join(cells) for cells in rows)], said


def _settings(lines: Sequence[str], separator: str) -> dict[str, list[str]]:
    """Return what is set, by its name in lower case."""
    rows = [line.replace("\t", separator).split(separator) for line in lines]
    return {row[0].strip().casefold(): [c.strip() for c in row[1:]] for row in rows if row[0].strip()}


def _first(settings: dict[str, list[str]], name: str, otherwise: str) -> str:
    """Return what is set first by a name, or otherwise where nothing is."""
    return next(iter(settings.get(name, [])), "") or otherwise


def _header(names: Sequence[str], settings: dict[str, list[str]], timed: str) -> list[str]:
    """Return the names of the columns, with the units that the settings give each channel."""
    units, made, channel = settings.get("y_unit_label", []), [], 0
    is_time = all(said.casefold() == "time" for said in settings.get("x_dimension", []) if said)
    for i, name in enumerate(names):
        if name == X_VALUE and (i == 0 or timed == "multi"):
            made.append("time (s)" if is_time else name)
            continue
        unit = units[channel] if channel < len(units) else ""
        made.append(f"{name} ({unit})" if unit and "(" not in name and "[" not in name else name)
        channel += 1
    return made
