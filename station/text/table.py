"""The paper's Table 1 (each release) and Table 2 (mean and standard deviation), for any number of sessions."""

import csv
import io
import math
from dataclasses import dataclass
from statistics import fmean, stdev
from typing import Any

from identify.formatting import decimals_for
from station.results.identification_document import IdentificationDocument, MethodDocument
from station.text.numbers import scale, with_error

MOST_DECIMALS = 8
METHODS = ("WT", "RFS")
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
        return Cell(_number(found.value), _number(found.std))


def _number(value: float | None) -> float:
    return math.nan if value is None else value


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


def number(value: float, std: float) -> str:
    """Return a value with as many decimals as two figures of its error have."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.{min(MOST_DECIMALS, decimals_for(std))}f}"


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


def as_latex(tables: Tables) -> str:
    """Return both tables as LaTeX tabulars, without packages."""
    kinds = "l" + "r" * (len(tables.columns) + 1)
    lines = [f"\\begin{{tabular}}{{{kinds}}}", "\\hline"]
    heads = [f"{_symbol(name)} ({method})" for name, method, _ in tables.columns]
    lines.append(" & ".join(["Release", "Amplitude", *heads]) + " \\\\")
    units = [f"{_unit(unit)}" for _, _, unit in tables.columns]
    lines.append(" & ".join(["", "", *units]) + " \\\\ \\hline")
    for row in tables.rows:
        cells = [_pair(cell) for cell in row.cells]
        amplitude = "--" if row.amplitude is None else f"{row.amplitude:.4f} {row.unit}"
        lines.append(
            " & ".join([f"{_escaped(row.session)}{'' if row.quotable else '$^*$'}", amplitude, *cells])
            + " \\\\"
        )
    lines += ["\\hline", "\\end{tabular}", *(f"{line} \\\\" for line in _doubt(tables)), ""]
    lines += [f"\\begin{{tabular}}{{l{'r' * len(tables.columns)}}}", "\\hline"]
    heads = []
    for name, _, unit in tables.columns[::2]:
        heads += [f"{_symbol(name)} [{_unit(unit)}]", f"$\\sigma$ {_symbol(name)}"]
    lines.append(" & ".join(["", *heads]) + " \\\\ \\hline")
    for method, means in tables.summary:
        line = [method]
        for cell in means:
            line += ["--", "--"] if cell is None else [number(cell.value, cell.std), _spread(cell)]
        lines.append(" & ".join(line) + " \\\\")
    lines += ["\\hline", "\\end{tabular}", ""]
    return "\n".join(lines)


def _pair(cell: Cell | None) -> str:
    return "--" if cell is None else f"${number(cell.value, cell.std)} \\pm {_spread(cell)}$"


def _spread(cell: Cell) -> str:
    return f"{cell.std:.2g}" if math.isfinite(cell.std) else "--"


def _symbol(name: str) -> str:
    return "$K$" if name == "K" else f"$\\mu_{{{name.removeprefix('mu_')}}}$"


def _unit(unit: str) -> str:
    return unit.replace("^2", "$^2$").replace("^3", "$^3$")


def _escaped(text: str) -> str:
    return "".join(f"\\{sign}" if sign in "_#%&${}" else sign for sign in text)


def as_text(tables: Tables) -> str:
    """Return both tables as text within 80 columns."""
    out = ["Table 1. Identified parameters, one line a release (± one standard error)", ""]
    names = [_within(f"{row.session}{'' if row.quotable else '*'}") for row in tables.rows]
    width = max([7, *(len(name) for name in names)])
    for first in range(0, len(tables.columns), 2):
        name, _, unit = tables.columns[first]
        out.append(
            f"{'release':<{width}}  {'amplitude':>10}  {f'{name} (WT)':>18}  {f'{name} (RFS)':>18}  {unit}"
        )
        for shown, row in zip(names, tables.rows, strict=True):
            amplitude = "-" if row.amplitude is None else _length(row.amplitude, row.unit)
            cells = [_plain(cell) for cell in row.cells[first : first + 2]]
            out.append(f"{shown:<{width}}  {amplitude:>10}  {cells[0]:>18}  {cells[1]:>18}")
        out.append("")
    if doubt := _doubt(tables):
        out += [*doubt, ""]
    if len(tables.rows) < 2:
        return "\n".join(out).rstrip("\n") + "\n"
    out.append(f"Table 2. Mean and standard deviation over {len(tables.rows)} releases")
    out.append("")
    both = dict(tables.summary)
    out.append(f"{'':<6}{'unit':<8}" + "".join(f"  {method:>22}" for method in both))
    for place, (name, _, unit) in enumerate(tables.columns[::2]):
        out.append(
            f"{name:<6}{unit:<8}" + "".join(f"  {_plain(means[place]):>22}" for means in both.values())
        )
    return "\n".join(out) + "\n"


def _within(name: str) -> str:
    """Return a name, its middle left out where it is longer than a table of 80 columns has place for."""
    return name if len(name) <= LONGEST_NAME else f"{name[:10]}..{name[12 - LONGEST_NAME :]}"


def _doubt(tables: Tables) -> list[str]:
    """Return the note under a table in which values stand that must not be quoted."""
    if all(row.quotable for row in tables.rows):
        return []
    return [
        "* do not quote: the identified model does not explain this record, the",
        "  methods disagree, or its sampling rate is not known well enough.",
    ]


def _plain(cell: Cell | None) -> str:
    if cell is None:
        return "-"
    return with_error(cell.value, cell.std) if math.isfinite(cell.std) else f"{cell.value:.4g} (one)"


def _length(value: float, unit: str) -> str:
    factor, text = scale("displacement", unit)
    return f"{value * factor:.4g} {text}"
