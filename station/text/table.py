"""The paper's Table 1 (each release) and Table 2 (mean and standard deviation), for any number of sessions."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from statistics import fmean, stdev
from typing import Any

from identify.estimate import Estimate
from identify.formatting import DASH, SPACE, with_error
from station.story.engineering_values import UNKNOWN, Weighing
from station.story.pipeline import Identification
from station.text.content import Paragraph, Table
from station.text.numbers import amplitude_words, typeset, typeset_unit

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


def make_tables(found: Sequence[tuple[str, Identification]], *, plain: bool = False) -> Tables:
    """Make both tables of identified sessions, each by its name, which share their units.

    In `plain` ones, for JSON, mu_i is per unit mass.
    """
    cells = [_cells_of(result, UNKNOWN if plain else result.weighing) for _, result in found]
    units = {key.rpartition(" ")[0]: one.unit for known in cells for key, one in known.items()}
    units |= {"K": units.pop("K")} if units else {}
    keys = [f"{name} ({label})" for name in units for label in METHODS]
    table_1: list[Row] = [
        {
            "session": name,
            "amplitude": result.amplitude,
            "amplitude_unit": result.decay.unit,
            "quotable": result.adequacy is None or result.adequacy.quotable,
            **{key: known.get(key) for key in keys},
        }
        for (name, result), known in zip(found, cells, strict=True)
    ]
    table_2 = [
        {"method": label} | {name: _mean([r[f"{name} ({label})"] for r in table_1]) for name in units}
        for label in METHODS
    ]
    return Tables(units, table_1, table_2)


def _cells_of(result: Identification, weighing: Weighing) -> dict[str, Estimate]:
    """Return the estimates of a session by "K (WT)"."""
    found = {}
    for label, method in zip(METHODS, (result.wavelet, result.restoring_force), strict=True):
        if method is not None:
            found[f"K ({label})"] = method.stiffness
            found |= {f"mu_{n} ({label})": weighing.strength(one) for n, one in enumerate(method.damping)}
    return found


def _mean(cells: list[Estimate | None]) -> Row | None:
    known = [cell for cell in cells if cell is not None and math.isfinite(cell.value)]
    if not known:
        return None
    values = [cell.value for cell in known]
    std = stdev(values) if len(values) > 1 else math.nan
    return {"mean": fmean(values), "std": std, "unit": known[0].unit}


def told(tables: Tables) -> tuple[Table, ...]:
    """Tell both tables, a line a release, the second only of several; unquotable releases have a star."""
    columns = tables.columns
    named = [f"{typeset(name)} [{typeset_unit(unit)}]" for name, unit in columns.items()]
    rows = tuple(
        (
            f"{row['session']}{'' if row['quotable'] else '*'}",
            amplitude_words(row["amplitude"], row["amplitude_unit"]),
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


def _cell(cell: Estimate | Row | None) -> str:
    if cell is None:
        return DASH
    if isinstance(cell, Estimate):
        return with_error(cell.value, cell.std)
    return (
        with_error(cell["mean"], cell["std"]) if math.isfinite(cell["std"]) else f"{cell['mean']:.4g} (one)"
    )


def in_pieces(tables: Tables) -> list[Table | Paragraph]:
    """Make both tables for a narrow place, Table 1 in pieces of one parameter each, and the note under them."""
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
    return [*pieces, *second, *([Paragraph(tables.doubt)] if tables.doubt else [])]


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
