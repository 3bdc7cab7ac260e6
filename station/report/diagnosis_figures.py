"""The suspects and the curves in figures for paper."""

from textwrap import fill

import numpy as np

from identify.diagnosis.force_map import ForceMap
from station.report.drawing import embedded, paper
from station.results.curves import NamedCurves
from station.results.diagnosis_document import CurveDocument
from station.results.diagnosis_fits import DiagnosisFits
from station.story.measured_curves import MeasuredCurve
from station.views import plots
from station.views.curve_panels import draw_panels
from station.views.plots import PAPER, literal


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
