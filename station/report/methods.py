"""The section of both identifications, side by side: the paper's tables and figures."""

from identify.estimate import Estimate
from identify.formatting import damping_name
from station.report import identification_figures as draw
from station.report.content import Figure, Paragraph, Part, Section, Table, left_out
from station.report.findings import Findings
from station.story.adequacy import judgement
from station.text.layout import sentence
from station.text.numbers import (
    lowered,
    scale,
    typeset,
    typeset_error,
    typeset_figures,
    typeset_symbol,
    typeset_unit,
)
from station.text.table import Tables, make_tables

TITLE = "Identification by two methods"
NONE = "–"


def methods(found: Findings) -> Section:
    """Put both methods side by side; what was refused says why."""
    result = found.identification
    if result is None or found.document is None:
        return Section("methods", TITLE, (left_out(found.left_out["identification"]),))
    parts: list[Part] = []
    for name, label in (("wavelet", "Wavelet (WT)"), ("restoring_force", "Restoring force surface (RFS)")):
        if name in result.refusals:
            parts.append(Paragraph(f"not identified: {result.refusals[name].rstrip('.')}.", label=label))
    if result.wavelet is None and result.restoring_force is None:
        return Section("methods", TITLE, tuple(parts))
    judged = result.adequacy
    if judged is not None and not judged.quotable:
        parts.append(Paragraph(sentence(typeset(judgement(judged))), label="Judged", strong=True))
    tables = make_tables([found.document])
    parts += [_table_1(tables), _table_2(found), _details(found)]
    if result.wavelet is not None:
        parts.append(
            Paragraph(f"{result.wavelet.reason}; {result.wavelet.stiffness_reason}.", label="Wavelet")
        )
    if result.restoring_force is not None:
        source = result.restoring_force.source
        parts.append(Paragraph(f"{result.restoring_force.reason}. From {source}.", label="Restoring force"))
    return Section("methods", TITLE, (*parts, *_figures(found)))


def _table_1(tables: Tables) -> Table:
    head = ["release", "amplitude"]
    for name, method, label in tables.columns:
        head.append(f"{typeset_symbol(name)} ({method}) [{typeset_unit(label)}]")
    rows = []
    for row in tables.rows:
        amplitude = NONE if row.amplitude is None else _length(row.amplitude, row.unit)
        cells = [NONE if c is None else typeset_error(c.value, c.std) for c in row.cells]
        rows.append((row.session, amplitude, *cells))
    return Table("Table 1. Identified parameters (± one standard error)", tuple(head), tuple(rows))


def _length(value: float, name: str) -> str:
    factor, label = scale("displacement", name)
    return f"{value * factor:.4g} {typeset_unit(label)}"


def _table_2(found: Findings) -> Table:
    """Return the paper's comparison of the results, for this release: both values, and how far they are apart."""
    assert found.identification is not None
    both = (found.identification.wavelet, found.identification.restoring_force)
    rows = [_row("K", "stiffness", [None if m is None else m.stiffness for m in both])]
    rows[0] = (*rows[0][:5], _apart([None if m is None else m.stiffness_per_mass for m in both]))
    most = max(len(method.damping) for method in both if method is not None)
    for order in range(most):
        values = [m.damping[order] if m is not None and order < len(m.damping) else None for m in both]
        rows.append(_row(f"mu_{order}", damping_name(order).rsplit(" ", 1)[0], values))
    for order in sorted({n for m in both if m is not None for n in m.stiffness_by_order} - {1}):
        values = [None if m is None else m.stiffness_by_order.get(order) for m in both]
        rows.append(_row(f"K{lowered(order)}", f"stiffness of order {order}", values))
    head = ("", "parameter", "unit", "WT", "RFS", "apart by (joint std. errors)")
    caption = "Table 2. Comparison of the results (this release; ± one standard error)"
    return Table(caption, head, tuple(rows), texts=3)


def _row(name: str, meaning: str, values: list[Estimate | None]) -> tuple[str, ...]:
    label = next((value.unit for value in values if value is not None), "")
    cells = [NONE if value is None else typeset_error(value.value, value.std) for value in values]
    return (typeset_symbol(name), meaning, typeset_unit(label), *cells, _apart(values))


def _apart(values: list[Estimate | None]) -> str:
    first, second = values
    if first is None or second is None:
        return NONE
    joint = (first.std**2 + second.std**2) ** 0.5
    return f"{abs(first.value - second.value) / joint:.1f}" if joint > 0 else NONE


def _details(found: Findings) -> Table:
    assert found.identification is not None
    both = (found.identification.wavelet, found.identification.restoring_force)
    rows = [
        ("order of damping", *(NONE if m is None else str(m.order) for m in both)),
        (
            "error left, MSE [%]",
            *(NONE if m is None else typeset_figures(m.mse_percent_by_order[m.order]) for m in both),
        ),
    ]
    force = found.identification.restoring_force
    if force is not None:
        offset = f"{typeset_error(force.offset.value, force.offset.std)} {typeset_unit(force.offset.unit)}"
        rows.append(("constant force per unit mass", NONE, offset))
        if force.mass is not None:
            rows.append(
                (
                    "mass, by the force",
                    NONE,
                    f"{typeset_error(force.mass.value, force.mass.std)} {typeset_unit(force.mass.unit)}",
                )
            )
    return Table("What each method leaves", ("", "WT", "RFS"), tuple(rows))


def _figures(found: Findings) -> list[Figure]:
    result = found.identification
    assert result is not None
    length, force = result.decay.unit, result.restoring_force
    figures = []
    if result.wavelet is not None:
        caption = (
            "Envelope on the ridge with its fit, instantaneous frequency (where it can be trusted), and backbone. "
            "A frequency that stays level means a linear stiffness."
        )
        figures.append(Figure(caption, draw.envelope(result.wavelet, length)))
    caption = "Error against the order of damping (circle: the order chosen), and significance of the terms."
    figures.append(Figure(caption, draw.orders(result)))
    caption = "Measured (grey) and reconstructed signals (dark), and what the reconstruction leaves."
    figures.append(Figure(caption, draw.reconstruction(result)))
    if force is not None:
        figures.append(
            Figure("Restoring force surface with the measured points.", draw.surface(force, length))
        )
        figures.append(Figure("Sections of the surface.", draw.sections(force, length)))
    return figures
