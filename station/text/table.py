"""The paper's Table 1 (each release) and Table 2 (mean and standard deviation), for any number of sessions."""

import csv
import io
import math
from dataclasses import dataclass, replace
from statistics import fmean, stdev
from typing import Any

from rich.console import Console

from station.results.identification_document import IdentificationDocument, MethodDocument
from station.text.content import Paragraph, Table
from station.text.layout import show_parts
from station.text.numbers import DASH, SPACE, or_nan, scale, typeset_symbol, typeset_unit, with_error

METHODS = ("WT", "RFS")
_RAISED = {raised: f"$^{plain}$" for raised, plain in zip("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789", strict=True)}
LATEX = {sign: f"\\{sign}" for sign in "_#%&${}"} | _RAISED | {
    "⁻": "$^-$", "±": "$\\pm$", "×": "$\\times$", "μ": "$\\mu$", "µ": "$\\mu$", SPACE: "~",
    **{low: f"$_{plain}$" for low, plain in zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True)},
}  # fmt: skip
LONGEST_NAME = 22


def _methods(document: IdentificationDocument) -> tuple[MethodDocument | None, MethodDocument | None]:
    return document.wavelet, document.restoring_force


@dataclass(frozen=True)
class Quantity:
    """One column of the tables: its name, its unit, and its order of damping (None: the stiffness)."""

    name: str
    unit: str
    order: int | None

    def of(self, method: MethodDocument | None) -> "Cell | None":
        """Return value and standard error by one method, or None."""
        if method is None or (self.order is not None and self.order >= len(method.damping)):
            return None
        found = method.stiffness if self.order is None else method.damping[self.order]
        return Cell(or_nan(found.value), or_nan(found.std))


@dataclass(frozen=True)
class Cell:
    """Value and standard error (Table 1) or mean and standard deviation (Table 2)."""

    value: float
    std: float


@dataclass(frozen=True)
class Row:
    """One session: its name, the amplitude just after its release with its unit, and a cell for each column.

    `quotable` is False where the identified model does not explain the record, or the methods disagree.
    """

    session: str
    amplitude: float | None
    unit: str
    cells: tuple[Cell | None, ...]
    quotable: bool = True


@dataclass(frozen=True)
class Tables:
    """Table 1 as rows and columns; Table 2 as one line for each method."""

    columns: tuple[tuple[str, str, str], ...]
    rows: tuple[Row, ...]
    summary: tuple[tuple[str, tuple[Cell | None, ...]], ...]


def make_tables(documents: list[IdentificationDocument]) -> Tables:
    """Make both tables of identified sessions."""
    quantities = _quantities(documents)
    columns = tuple((q.name, label, q.unit) for q in quantities for label in METHODS)
    rows = tuple(
        Row(
            document.session,
            document.release.amplitude,
            document.record.unit,
            tuple(q.of(method) for q in quantities for method in _methods(document)),
            document.adequacy is None or document.adequacy.quotable,
        )
        for document in documents
    )
    summary = tuple(
        (label, tuple(_mean([q.of(_methods(document)[place]) for document in documents]) for q in quantities))
        for place, label in enumerate(METHODS)
    )
    return Tables(columns, rows, summary)


def _quantities(documents: list[IdentificationDocument]) -> list[Quantity]:
    methods = [method for document in documents for method in _methods(document) if method is not None]
    if not methods:
        return []
    most = max(len(method.damping) for method in methods)
    quantities = []
    for order in range(most):
        unit = next(m.damping[order].unit for m in methods if len(m.damping) > order)
        quantities.append(Quantity(f"mu_{order}", unit, order))
    units = sorted({method.stiffness.unit for method in methods})
    return [*quantities, Quantity("K", " or ".join(units), None)]


def _mean(found: list[Cell | None]) -> Cell | None:
    values = [cell.value for cell in found if cell is not None and math.isfinite(cell.value)]
    if not values:
        return None
    return Cell(fmean(values), stdev(values) if len(values) > 1 else math.nan)


def as_json(tables: Tables) -> dict[str, Any]:
    """Return both tables as a document."""
    names = [f"{name} ({method})" for name, method, _ in tables.columns]
    quantities = [(name, unit) for name, _, unit in tables.columns[::2]]
    return {
        "table_1": [
            {
                "session": row.session,
                "amplitude": row.amplitude,
                "amplitude_unit": row.unit,
                "quotable": row.quotable,
            }
            | {
                key: None if cell is None else {"value": cell.value, "std": cell.std, "unit": unit}
                for key, cell, (_, _, unit) in zip(names, row.cells, tables.columns, strict=True)
            }
            for row in tables.rows
        ],
        "table_2": [
            {"method": method}
            | {
                name: None if cell is None else {"mean": cell.value, "std": cell.std, "unit": unit}
                for (name, unit), cell in zip(quantities, cells, strict=True)
            }
            for method, cells in tables.summary
        ],
    }


def as_csv(tables: Tables) -> str:
    """Return both tables as CSV, one under the other, each with a header that carries the units."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    header = ["session", "amplitude", "amplitude unit"]
    for name, method, unit in tables.columns:
        header += [f"{name} ({method}) [{unit}]", f"std {name} ({method}) [{unit}]"]
    writer.writerow([*header, "quotable"])
    for row in tables.rows:
        line: list[object] = [row.session, "" if row.amplitude is None else f"{row.amplitude:.6g}", row.unit]
        for cell in row.cells:
            line += ["", ""] if cell is None else [repr(cell.value), repr(cell.std)]
        writer.writerow([*line, "yes" if row.quotable else "no"])
    writer.writerow([])
    header = ["method"]
    for name, _, unit in tables.columns[::2]:
        header += [f"mean {name} [{unit}]", f"std {name} [{unit}]"]
    writer.writerow(header)
    for method, cells in tables.summary:
        line = [method]
        for cell in cells:
            line += ["", ""] if cell is None else [repr(cell.value), repr(cell.std)]
        writer.writerow(line)
    return out.getvalue()


def told(tables: Tables) -> tuple[Table, ...]:
    """Tell both tables, a line a release, the second only of several; unquotable releases have a star."""
    head = [f"{typeset_symbol(name)} ({method})" for name, method, _ in tables.columns]
    units = [typeset_unit(unit) for _, _, unit in tables.columns]
    rows = tuple(
        (f"{row.session}{'' if row.quotable else '*'}", _amplitude(row), *map(_cell, row.cells))
        for row in tables.rows
    )
    named = tuple(f"{name} [{unit}]" for name, unit in zip(head, units, strict=True))
    first = Table(
        "Table 1. Identified parameters (± one standard error)", ("release", "amplitude", *named), rows
    )
    if len(tables.rows) < 2:
        return (first,)
    columns = zip(*(cells for _, cells in tables.summary), strict=True)
    means = tuple(
        (typeset_symbol(name), typeset_unit(unit), *map(_cell, cells))
        for (name, _, unit), cells in zip(tables.columns[::2], columns, strict=True)
    )
    caption = f"Table 2. Mean and standard deviation over {len(tables.rows)} releases"
    return first, Table(caption, ("", "unit", *METHODS), means, texts=2)


def as_text(tables: Tables) -> str:
    """Write both tables as text within 80 columns: Table 1 in pieces of one parameter each."""
    out = io.StringIO()
    console = Console(file=out, width=80, highlight=False, no_color=True)
    first, *second = told(tables)
    pieces = [
        replace(
            first,
            caption=first.caption if place == 2 else "",
            head=(*first.head[:2], *first.head[place : place + 2]),
            rows=tuple((_within(row[0]), row[1], *row[place : place + 2]) for row in first.rows),
        )
        for place in range(2, len(first.head), 2)
    ]
    for piece in (*pieces, *second):
        show_parts(console, [piece])
    show_parts(console, [Paragraph(words) for words in doubt(tables)])
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"


def as_latex(tables: Tables) -> str:
    """Write both tables as LaTeX tabulars, without packages."""
    return "\n".join([*map(_tabular, told(tables)), *(f"{words} \\\\" for words in doubt(tables)), ""])


def _tabular(table: Table) -> str:
    kinds = "l" * table.texts + "r" * (len(table.head) - table.texts)
    lines = [" & ".join(map(_escaped, row)) + " \\\\" for row in (table.head, *table.rows)]
    return "\n".join(
        (
            f"\\begin{{tabular}}{{{kinds}}}",
            "\\hline",
            lines[0],
            "\\hline",
            *lines[1:],
            "\\hline",
            "\\end{tabular}",
        )
    )


def _escaped(text: str) -> str:
    return "".join(LATEX.get(sign, sign) for sign in text)


def _amplitude(row: Row) -> str:
    if row.amplitude is None:
        return DASH
    factor, unit = scale("displacement", row.unit)
    return f"{abs(row.amplitude) * factor:.4g} {unit}"


def _within(name: str) -> str:
    """Leave out the middle of a name that is longer than a table of 80 columns has place for."""
    return name if len(name) <= LONGEST_NAME else f"{name[:10]}..{name[12 - LONGEST_NAME :]}"


def doubt(tables: Tables) -> list[str]:
    """Write the note under a table in which values stand that must not be quoted."""
    if all(row.quotable for row in tables.rows):
        return []
    return [
        "* do not quote: the identified model does not explain this record, the methods disagree, or its sampling rate is "
        "not known well enough."
    ]


def _cell(cell: Cell | None) -> str:
    if cell is None:
        return DASH
    return with_error(cell.value, cell.std) if math.isfinite(cell.std) else f"{cell.value:.4g} (one)"
