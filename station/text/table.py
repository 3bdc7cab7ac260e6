"""The paper's Table 1 (each release) and Table 2 (mean and standard deviation), for any number of sessions."""

import io
import math
from dataclasses import dataclass, replace
from statistics import fmean, stdev
from typing import Any

from rich.console import Console

from identify.formatting import DASH, SPACE, with_error
from station.results import documents
from station.results.documents import EstimateDocument
from station.story.engineering_values import UNKNOWN, Weighing
from station.text.content import Paragraph, Table
from station.text.layout import show_parts
from station.text.numbers import scale, typeset, typeset_unit

METHODS = ("WT", "RFS")
_RAISED = {raised: f"$^{plain}$" for raised, plain in zip("⁰¹²³⁴⁵⁶⁷⁸⁹", "0123456789", strict=True)}
LATEX = str.maketrans(
    {sign: f"\\{sign}" for sign in "_#%&${}"} | _RAISED | {
    "⁻": "$^-$", "±": "$\\pm$", "×": "$\\times$", "μ": "$\\mu$", "µ": "$\\mu$", SPACE: "~",
    **{low: f"$_{plain}$" for low, plain in zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True)},
})  # fmt: skip
DO_NOT_QUOTE = (
    "* do not quote: the identified model does not explain this record, the methods disagree, or its sampling rate is "
    "not known well enough."
)

Row = dict[str, Any]


@dataclass(frozen=True)
class Tables:
    """Both tables: a row for each release, and a row for each method.

    `units` are those of the parameters, by name; a cell is an estimate, or a mean with its standard deviation, or None.
    A release is not `quotable` where the identified model does not explain the record, or the methods disagree.
    """

    units: dict[str, str]
    table_1: list[Row]
    table_2: list[Row]

    @property
    def columns(self) -> dict[str, str]:
        """Table 1's columns of parameters, as "K (WT)", with the unit of each."""
        return {f"{name} ({label})": unit for name, unit in self.units.items() for label in METHODS}

    @property
    def doubt(self) -> str:
        """The note under a table in which values stand that must not be quoted; "" where there are none."""
        return "" if all(row["quotable"] for row in self.table_1) else DO_NOT_QUOTE


def make_tables(documents: list[dict[str, Any]], *, plain: bool = False) -> Tables:
    """Make both tables of identified sessions, which share their units; mu_i in `plain` ones, for JSON, is per unit mass."""
    cells = [_cells_of(document, plain) for document in documents]
    units = {key.rpartition(" ")[0]: one["unit"] for found in cells for key, one in found.items()}
    units |= {"K": units.pop("K")} if units else {}
    keys = [f"{name} ({label})" for name in units for label in METHODS]
    table_1: list[Row] = [
        {
            "session": document["session"],
            "amplitude": document["release"]["amplitude"],
            "amplitude_unit": document["record"]["unit"],
            "quotable": document["adequacy"] is None or document["adequacy"]["quotable"],
            **{key: found.get(key) for key in keys},
        }
        for document, found in zip(documents, cells, strict=True)
    ]
    table_2 = [
        {"method": label} | {name: _mean([r[f"{name} ({label})"] for r in table_1]) for name in units}
        for label in METHODS
    ]
    return Tables(units, table_1, table_2)


def _cells_of(document: dict[str, Any], plain: bool) -> dict[str, Row]:
    """Return the estimates of a session by "K (WT)"."""
    found, record = {}, document["record"]
    weighing = UNKNOWN if plain else Weighing(record["mass_kg"], record["mass_std_kg"], record["unit"])
    for label, method in zip(METHODS, (document["wavelet"], document["restoring_force"]), strict=True):
        if method is not None:
            found[f"K ({label})"] = method["stiffness"]
            for order, one in enumerate(method["damping"]):
                whole = weighing.strength(EstimateDocument.model_validate(one))
                found[f"mu_{order} ({label})"] = documents.plain(whole)
    return found


def _mean(cells: list[Row | None]) -> Row | None:
    known = [cell for cell in cells if cell is not None and cell["value"] is not None]
    if not known:
        return None
    values = [cell["value"] for cell in known]
    std = stdev(values) if len(values) > 1 else math.nan
    return {"mean": fmean(values), "std": std, "unit": known[0]["unit"]}


def told(tables: Tables) -> tuple[Table, ...]:
    """Tell both tables, a line a release, the second only of several; unquotable releases have a star."""
    columns = tables.columns
    named = [f"{typeset(name)} [{typeset_unit(unit)}]" for name, unit in columns.items()]
    rows = tuple(
        (
            f"{row['session']}{'' if row['quotable'] else '*'}",
            _amplitude(row),
            *(_cell(row[c]) for c in columns),
        )
        for row in tables.table_1
    )
    head = ("release", "amplitude", *named)
    first = Table(
        "Table 1. Identified parameters (± one standard error) by wavelet (WT) and restoring force (RFS)",
        head,
        rows,
    )
    if len(rows) < 2:
        return (first,)
    means = tuple(
        (typeset(name), typeset_unit(unit), *(_cell(row[name]) for row in tables.table_2))
        for name, unit in tables.units.items()
    )
    caption = f"Table 2. Mean and standard deviation over {len(rows)} releases"
    return first, Table(caption, ("", "unit", *METHODS), means, texts=2)


def _amplitude(row: Row) -> str:
    if row["amplitude"] is None:
        return DASH
    factor, unit = scale("displacement", row["amplitude_unit"])
    return f"{abs(row['amplitude']) * factor:.4g} {unit}"


def _cell(cell: Row | None) -> str:
    if cell is None:
        return DASH
    value, std, _ = cell.values()
    return with_error(value, std) if std is None or math.isfinite(std) else f"{value:.4g} (one)"


def in_pieces(tables: Tables) -> list[Table]:
    """Make both tables for a narrow place: Table 1 in pieces of one parameter each."""
    first, *second = told(tables)
    pieces = [
        replace(
            first,
            caption=first.caption if place == 2 else "",
            head=(*first.head[:2], *first.head[place : place + 2]),
            rows=tuple((*row[:2], *row[place : place + 2]) for row in first.rows),
        )
        for place in range(2, len(first.head), 2)
    ]
    return [*pieces, *second]


def as_text(tables: Tables) -> str:
    """Write both tables as text within 80 columns."""
    out = io.StringIO()
    console = Console(file=out, width=80, highlight=False, no_color=True)
    show_parts(console, [*in_pieces(tables), *([Paragraph(tables.doubt)] if tables.doubt else [])])
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()) + "\n"


def as_latex(tables: Tables) -> str:
    """Write both tables as LaTeX tabulars, without packages."""
    return "\n".join([*map(_tabular, told(tables)), *([f"{tables.doubt} \\\\"] if tables.doubt else []), ""])


def _tabular(table: Table) -> str:
    kinds = "l" * table.texts + "r" * (len(table.head) - table.texts)
    head, *rows = (
        " & ".join(cell.translate(LATEX) for cell in row) + " \\\\" for row in (table.head, *table.rows)
    )
    lines = (f"\\begin{{tabular}}{{{kinds}}}", "\\hline", head, "\\hline", *rows, "\\hline", "\\end{tabular}")
    return "\n".join(lines)
