"""The suspects, the curves and the residuals in figures."""

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from identify.arrays import Array
from identify.curves.laid_over import DecayCurves
from identify.diagnosis.force_map import ForceMap
from identify.formatting import plain_name
from station.results.diagnosis_parts import CurveDocument
from station.story.measured_curves import MeasuredCurve
from station.text.numbers import scale_as_recorded
from station.views.curve_panels import draw_panels
from station.views.figure import Picture, figure, literal
from station.views.palette import PAPER, Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def force_maps(maps: Sequence[tuple[str, ForceMap]], unit: str) -> Picture:
    """Draw the mean force over the phase of the cycle: what the model lacks, then what each suspect would add."""
    drawn, axes = figure(PAPER, 2.1, 1, len(maps), sharey=True, width=min(6.9, 1.9 * len(maps) + 0.6))
    for axis, (name, found) in zip(axes, maps, strict=True):
        degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
        axis.axhline(0, color=PAPER.faint, lw=0.7)
        axis.plot(degrees, found.large, color=PAPER.second, lw=1.5, label="large cycles")
        axis.plot(degrees, found.small, color=PAPER.model, lw=1.3, ls="--", label="small cycles")
        axis.set(xlabel="phase of the cycle [°]", xticks=range(0, 361, 90), xlim=(0, 360))
        axis.set_title(literal(fill(plain_name(name), 20)), fontsize=8)
    reach = _reach(maps[0][1])
    axes[0].set_ylim(-1.5 * reach, 1.5 * reach)
    axes[0].set_ylabel(literal(f"force per unit\nmass [{unit}/s^2]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return drawn


def curves(found: DecayCurves, names: Sequence[str], look: Look = PAPER) -> Picture:
    """Draw frequency and damping of the releases against amplitude, with the laws laid over."""
    drawn, axes = figure(look, 3.4, 1, 2)
    draw_panels(axes, found, names, look)
    return drawn


def _reach(found: ForceMap) -> float:
    values = np.abs(np.concatenate([found.large, found.small]))
    return float(np.nanmax(values)) if np.isfinite(values).any() and np.nanmax(values) > 0 else 1.0


def shape(curve: CurveDocument) -> Picture:
    """Draw the free form of a force that has no name, with two standard errors."""
    position, force, std = (
        np.array(one, dtype=float) for one in (curve.position, curve.force_per_mass, curve.std)
    )
    drawn, axis = _along(position, force, std, curve.unit, PAPER)
    axis.set_xlabel(literal(f"{curve.coordinate} {axis.get_xlabel()}"))
    axis.set_ylabel("missing force per unit mass\n(band: 2 std. errors)")
    return drawn


def measured_curve(curve: MeasuredCurve, look: Look = PAPER) -> Picture:
    """Draw a measured curve of a model, with two standard errors."""
    drawn, axis = _along(curve.position, curve.value, curve.std, curve.unit, look)
    axis.set_xlabel(literal(f"{curve.over} {axis.get_xlabel()}"))
    axis.set_ylabel(literal(f"measured curve, per unit mass\n[{curve.value_unit}] (band: 2 std. errors)"))
    return drawn


def _along(position: Array, value: Array, std: Array, unit: str, look: Look) -> tuple[Picture, "Axes"]:
    """Draw a curve with two standard errors over a position, whose unit is the axis' label."""
    drawn, (axis,) = figure(look, 2.4, width=4.2)
    factor, name = scale_as_recorded("displacement" if unit == "m" else "", unit)
    axis.fill_between(position * factor, value - 2 * std, value + 2 * std, color=look.noise, lw=0)
    axis.plot(position * factor, value, color=look.second, lw=1.5)
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.set_xlabel(f"[{name}]")
    return drawn, axis
