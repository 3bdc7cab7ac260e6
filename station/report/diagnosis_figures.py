"""The suspects, the curves and the ladder in figures for paper."""

from textwrap import fill

import numpy as np

from identify.diagnosis.force_map import ForceMap
from station.report.drawing import embedded, paper
from station.results.curves import NamedCurves
from station.results.diagnosis_document import CurveDocument, DiagnosisDocument
from station.results.diagnosis_fits import DiagnosisFits
from station.results.ladder import KeptLadder
from station.story.measured_curves import MeasuredCurve
from station.text.ladder_text import step_words
from station.views import plots
from station.views.curve_panels import draw_panels
from station.views.plots import PAPER, literal
from station.views.suspects import MOST_BARS


def errors(document: DiagnosisDocument) -> str | None:
    """Draw the residual after adding each suspect against the floor; None where there is nothing to draw."""
    rows = [("before", document.error.chi2)]
    rows += [(s.effect, s.error_after) for s in document.suspects]
    known = [(name, value) for name, value in rows if value is not None]
    spread = 0.0 if document.noise_floor is None else document.noise_floor.chi2_std
    return _residuals(known[: MOST_BARS + 1], spread, " with it added")


def steps(ladder: KeptLadder) -> str | None:
    """Draw the residual step by step down to the floor."""
    rows = [
        (f"{place}: {step_words(step)}", step.error.chi2)
        for place, step in enumerate(ladder.steps[: ladder.present + 1])
    ]
    return _residuals([(n, v) for n, v in rows if v is not None], ladder.top.chi2_std, "")


def _residuals(rows: list[tuple[str, float]], std: float, when: str) -> str | None:
    if not rows:
        return None
    drawn, (axis,) = paper(0.75 + 0.24 * len(rows))
    plots.residuals(axis, rows, std, PAPER, when=when)
    return embedded(drawn)


def force_maps(fits: DiagnosisFits) -> str:
    """Draw the force that the model lacks over the cycle beside what the best suspects would add."""
    maps = [("what the model lacks", fits.missing_force())]
    maps += [(term.effect.name, found) for term, found in fits.added_forces()]
    drawn, axes = paper(2.1, 1, len(maps), sharey=True, width=min(6.9, 1.9 * len(maps) + 0.6))
    for axis, (name, found) in zip(axes, maps, strict=True):
        plots.force_over_cycle(axis, found, PAPER)
        axis.set_xlabel("phase of the cycle [°]")
        axis.set_title(literal(fill(name.replace("_", " "), 20)), fontsize=8)
    reach = _reach(maps[0][1])
    axes[0].set_ylim(-1.5 * reach, 1.5 * reach)
    axes[0].set_ylabel(literal(f"force per unit\nmass [{fits.prepared.window.unit}/s^2]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return embedded(drawn)


def curves(shown: NamedCurves) -> str:
    """Draw frequency and damping of the releases against amplitude, with the laws laid over."""
    drawn, axes = paper(3.4, 1, 2)
    draw_panels(axes, shown.curves, shown.names, PAPER)
    return embedded(drawn)


def _reach(found: ForceMap) -> float:
    values = np.abs(np.concatenate([found.large, found.small]))
    return float(np.nanmax(values)) if np.isfinite(values).any() and np.nanmax(values) > 0 else 1.0


def shape(curve: CurveDocument) -> str:
    """Draw the free form of a force that has no name, with two standard errors."""
    drawn, (axis,) = paper(2.4, width=4.2)
    plots.shape(axis, curve, PAPER)
    return embedded(drawn)


def measured_curve(curve: MeasuredCurve) -> str:
    """Draw a measured curve of a model, with two standard errors."""
    drawn, (axis,) = paper(2.4, width=4.2)
    plots.measured_curve(axis, curve, PAPER)
    return embedded(drawn)
