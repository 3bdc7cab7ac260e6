"""Curves for the page: those of the diagnosis that a session keeps, as plain numbers."""

from pathlib import Path

from identify.curves.amplitude_curve import AmplitudeCurve
from identify.curves.laid_over import DecayCurves
from station.exits import UsageProblem
from station.operations.refining import Refinement
from station.operations.session_curves import kept_curves
from station.results.diagnosis_document import DiagnosisDocument
from station.settings import Settings
from station.text.numbers import scale
from station.views.curve_panels import PANELS, label, limits
from station.workbench import view_models
from station.workbench.build_view_models import EYE, Array, for_eye, numbers

MOST_KEPT = 8

_kept: dict[Path, tuple[DiagnosisDocument, view_models.DecayCurves | None]] = {}
"""What this worker has drawn of each session, since a look at a session asks for it every time."""


def curves_of(
    settings: Settings, refinement: Refinement, document: DiagnosisDocument | None
) -> view_models.DecayCurves | None:
    """Return the curves of the diagnosis that a session keeps; None where there is none, or no curve."""
    if document is None:
        return None
    session = refinement.session
    known = _kept.get(session.folder)
    if known is not None and known[0] == document:
        return known[1]
    try:
        shown = kept_curves(session, refinement.prepared, document, refinement.library, settings)
    except UsageProblem:  # an effect of a file that is not at hand
        shown = None
    drawn = None if shown is None else plain_curves(shown.names, shown.curves)
    while len(_kept) >= MOST_KEPT:
        _kept.pop(next(iter(_kept)))
    _kept[session.folder] = (document, drawn)
    return drawn


def plain_curves(names: tuple[str, ...], found: DecayCurves) -> view_models.DecayCurves:
    """Return releases and laws as the page draws them."""
    factor, unit = scale("displacement", found.unit)
    ranges = tuple(limits(panel, found) for panel in PANELS)
    lines = [_line(names[curve.release], "measured", curve, factor, ranges) for curve in found.releases]
    for laid in found.laws:
        lines += [_line(label(laid), laid.law.role, curve, factor, ranges) for curve in laid.curves]
    return view_models.DecayCurves(unit, tuple(lines), *ranges)


def _line(
    name: str, role: str, curve: AmplitudeCurve, factor: float, ranges: tuple[tuple[float, float], ...]
) -> view_models.AmplitudeLine:
    fine = [(high - low) / EYE for low, high in ranges]

    def plain(what: str, std: bool) -> view_models.Numbers:
        panel = next(i for i, panel in enumerate(PANELS) if panel.what == what)
        values: Array = getattr(curve, f"{what}_std" if std else what) * PANELS[panel].factor
        return numbers(values, fine[panel])

    return view_models.AmplitudeLine(
        name,
        role,
        for_eye(curve.amplitude * factor),
        plain("frequency", False),
        plain("frequency", True),
        plain("damping", False),
        plain("damping", True),
    )
