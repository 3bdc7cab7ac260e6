"""The suspects, the curves and the residuals in figures; viewer, page, report and notebook share them."""

from collections.abc import Sequence
from dataclasses import dataclass
from textwrap import fill

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import AmplitudeCurve
from identify.curves.laid_over import DecayCurves, LaidOver
from identify.diagnosis.force_map import ForceMap
from identify.estimate import Estimate
from identify.formatting import plain_name
from station.results.diagnosis_document import CurveDocument
from station.story.engineering_values import Weighing
from station.story.measured_curves import MeasuredCurve
from station.text.numbers import scale, scale_as_recorded
from station.views.figure import Axes, Picture, figure, literal
from station.views.palette import PAPER, Look

COLOURS = ("#0072b2", "#b35900", "#00795a", "#a0527f", "#6b6b00", "#444444")
MARKS = ("o", "s", "^", "v", "D", "P")
WIDTHS = {"usual": 0.9, "named": 2.2, "rival": 1.2}
RIVALS = ("--", ":")
DAMPING = "damping ratio [%]"
FREQUENCY = "frequency [Hz]"
FAR = 4.0
ROOM = 0.06
BAND = 2.0


def force_maps(maps: Sequence[tuple[str, ForceMap]], weighing: Weighing) -> Picture:
    """Draw the mean force over the phase of the cycle: what the model lacks, then what each suspect would add."""
    size, unit = weighing.force_scale
    drawn, axes = figure(PAPER, 2.1, 1, len(maps), sharey=True, width=min(6.9, 1.9 * len(maps) + 0.6))
    for axis, (name, found) in zip(axes, maps, strict=True):
        degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
        axis.axhline(0, color=PAPER.faint, lw=0.7)
        axis.plot(degrees, found.large * size, color=PAPER.second, lw=1.5, label="large cycles")
        axis.plot(degrees, found.small * size, color=PAPER.model, lw=1.3, ls="--", label="small cycles")
        axis.set(xlabel="phase of the cycle [°]", xticks=range(0, 361, 90), xlim=(0, 360))
        axis.set_title(literal(fill(plain_name(name), 20)), fontsize=8)
    reach = size * _reach(maps[0][1])
    axes[0].set_ylim(-1.5 * reach, 1.5 * reach)
    axes[0].set_ylabel(literal(f"{weighing.worded()}\n[{unit}]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return drawn


def _reach(found: ForceMap) -> float:
    values = np.abs(np.concatenate([found.large, found.small]))
    return float(np.nanmax(values)) if np.isfinite(values).any() and np.nanmax(values) > 0 else 1.0


def shape(curve: CurveDocument, weighing: Weighing) -> Picture:
    """Draw the free form of a force that has no name, with two standard errors."""
    size, unit = weighing.force_scale
    position, force, std = (
        np.array(one, dtype=float) for one in (curve.position, curve.force_per_mass, curve.std)
    )
    drawn, axis = _along(position, size * force, size * std, curve.unit, PAPER)
    axis.set_xlabel(literal(f"{curve.coordinate} {axis.get_xlabel()}"))
    axis.set_ylabel(literal(f"missing {weighing.worded()}\n[{unit}] (band: 2 std. errors)"))
    return drawn


def measured_curve(curve: MeasuredCurve, weighing: Weighing, look: Look = PAPER) -> Picture:
    """Draw a measured curve of a model, with two standard errors."""
    one = weighing.strength(Estimate(1.0, 0.0, curve.value_unit))
    drawn, axis = _along(curve.position, one.value * curve.value, one.value * curve.std, curve.unit, look)
    axis.set_xlabel(literal(f"{curve.over} {axis.get_xlabel()}"))
    words = weighing.worded("measured curve, per unit mass")
    axis.set_ylabel(literal(f"{words}\n[{one.unit}] (band: 2 std. errors)"))
    return drawn


def _along(position: Array, value: Array, std: Array, unit: str, look: Look) -> tuple[Picture, Axes]:
    """Draw a curve with two standard errors over a position, whose unit is the axis' label."""
    drawn, (axis,) = figure(look, 2.4, width=4.2)
    factor, name = scale_as_recorded("displacement" if unit == "m" else "", unit)
    axis.fill_between(position * factor, value - 2 * std, value + 2 * std, color=look.noise, lw=0)
    axis.plot(position * factor, value, color=look.second, lw=1.5)
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.set_xlabel(f"[{name}]")
    return drawn, axis


@dataclass(frozen=True)
class Panel:
    """What one of the two panels shows: an axis' label, and values with their errors in its unit."""

    label: str
    what: str
    factor: float

    def values(self, curve: AmplitudeCurve) -> Array:
        """Take the values of a curve that are drawn, (n,)."""
        return np.asarray(getattr(curve, self.what) * self.factor)

    def band(self, curve: AmplitudeCurve) -> Array:
        """Return two standard errors of it, (n,)."""
        return np.asarray(np.nan_to_num(BAND * getattr(curve, f"{self.what}_std") * self.factor))


PANELS = (Panel(FREQUENCY, "frequency", 1.0), Panel(DAMPING, "damping", 100.0))


def curves(found: DecayCurves, names: Sequence[str], look: Look = PAPER) -> Picture:
    """Draw frequency and damping against amplitude: releases as points with bands of two standard errors, laws as lines.

    `names` are the releases'.
    """
    drawn, axes = figure(look, 3.4, 1, 2)
    factor, unit = scale("displacement", found.unit)
    for axis, panel in zip(axes, PANELS, strict=True):
        for place, curve in enumerate(found.releases):
            look_of = COLOURS[place % len(COLOURS)], MARKS[place % len(MARKS)]
            _release(axis, panel, curve, factor, look_of, names[curve.release])
        rivals = [laid for laid in found.laws if laid.law.role == "rival"]
        for laid in found.laws:
            style = RIVALS[rivals.index(laid) % len(RIVALS)] if laid in rivals else "-"
            _law(axis, panel, laid, factor, look, style)
        axis.set(xlabel=literal(f"amplitude [{unit}]"), ylabel=panel.label)
        axis.set_ylim(*_limits(panel, found))
        axis.set_xlim(0.0, 1.04 * max(float(c.amplitude.max()) for c in found.releases) * factor)
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5)
    return drawn


def _release(
    axis: Axes, panel: Panel, curve: AmplitudeCurve, factor: float, look: tuple[str, str], name: str
) -> None:
    colour, mark = look
    edge = axis.get_facecolor()
    order = np.argsort(curve.amplitude)
    x, y, band = (
        values[order] for values in (curve.amplitude * factor, panel.values(curve), panel.band(curve))
    )
    axis.fill_between(x, y - band, y + band, color=colour, alpha=0.22, lw=0)
    axis.plot(x, y, mark, color=colour, ms=4.2, mew=0.4, mec=edge, zorder=3, label=literal(name))


def _law(axis: Axes, panel: Panel, laid: LaidOver, factor: float, look: Look, style: str) -> None:
    colour = (
        look.model if laid.law.role == "named" else look.ink if laid.law.role == "usual" else look.measured
    )
    for number, curve in enumerate(laid.curves):
        order = np.argsort(curve.amplitude)
        axis.plot(curve.amplitude[order] * factor, panel.values(curve)[order], style, color=colour,
                  lw=WIDTHS[laid.law.role], label=literal(_label(laid)) if number == 0 else "_", zorder=2.5)  # fmt: skip


def _label(laid: LaidOver) -> str:
    name = plain_name(laid.law.name)
    return {"usual": name, "named": f"with {name}", "rival": f"or {name}"}[laid.law.role]


def _limits(panel: Panel, found: DecayCurves) -> tuple[float, float]:
    """Return the range of a panel: of what each release shows well, and of the laws near it."""
    bottom, top = np.inf, -np.inf
    for curve in found.releases:
        values, band = panel.values(curve), panel.band(curve)
        known = band <= FAR * float(np.quantile(band, 0.25)) if band.any() else np.full(len(values), True)
        bottom = min(bottom, float(np.min((values - 0.5 * band)[known])))
        top = max(top, float(np.max((values + 0.5 * band)[known])))
    reach = top - bottom
    for laid in found.laws:
        for law in laid.curves:
            values = panel.values(law)
            near = values[(values > bottom - 0.5 * reach) & (values < top + 0.5 * reach)]
            bottom, top = float(np.min(near, initial=bottom)), float(np.max(near, initial=top))
    room = ROOM * (top - bottom) or 0.01 * max(abs(top), 1e-9)
    return bottom - room, top + room
