"""The suspects, the curves and the residuals in figures; viewer, page, report and notebook share them."""

from collections.abc import Sequence
from itertools import cycle
from textwrap import fill

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import AmplitudeCurve
from identify.curves.laid_over import DecayCurves
from identify.diagnosis.force_map import ForceMap
from identify.estimate import Estimate
from identify.formatting import plain_name
from station.results.diagnosis_document import CurveDocument
from station.story.engineering_values import Weighing
from station.story.measured_curves import MeasuredCurve
from station.text.numbers import scale, scale_as_recorded
from station.views.figure import Picture, figure, literal
from station.views.palette import LIGHT, Look

COLOURS = ("#0072b2", "#b35900", "#00795a", "#a0527f", "#6b6b00", "#444444")
MARKS = ("o", "s", "^", "v", "D", "P")
RIVALS = ("--", ":")
PANELS = {"frequency": ("frequency [Hz]", 1.0), "damping": ("damping ratio [%]", 100.0)}
"""Each quantity of a curve with the label of its axis, and the factor to its unit."""
FAR = 4.0
ROOM = 0.06
BAND = 2.0


def force_maps(maps: Sequence[tuple[str, ForceMap]], weighing: Weighing) -> Picture:
    """Draw the mean force over the phase of the cycle: what the model lacks, then what each suspect would add."""
    size, unit = weighing.force_scale
    drawn, axes = figure(LIGHT, 2.1, 1, len(maps), sharey=True, width=min(6.9, 1.9 * len(maps) + 0.6))
    for axis, (name, found) in zip(axes, maps, strict=True):
        degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
        axis.axhline(0, color=LIGHT.faint, lw=0.7)
        axis.plot(degrees, found.large * size, color=LIGHT.second, lw=1.5, label="large cycles")
        axis.plot(degrees, found.small * size, color=LIGHT.model, lw=1.3, ls="--", label="small cycles")
        axis.set(xlabel="phase of the cycle [°]", xticks=range(0, 361, 90), xlim=(0, 360))
        axis.set_title(literal(fill(plain_name(name), 20)), fontsize=8)
    lacks = np.abs([maps[0][1].large, maps[0][1].small])
    reach = 1.5 * size * (float(np.max(lacks, where=np.isfinite(lacks), initial=0.0)) or 1.0)
    axes[0].set_ylim(-reach, reach)
    axes[0].set_ylabel(literal(f"{weighing.worded()}\n[{unit}]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return drawn


def shape(curve: CurveDocument, weighing: Weighing) -> Picture:
    """Draw the free form of a force that has no name, with two standard errors."""
    position, force, std = (
        np.array(one, dtype=float) for one in (curve.position, curve.force_per_mass, curve.std)
    )
    unit = f"{weighing.unit}/s^2"
    form = MeasuredCurve("", "", curve.coordinate, curve.unit, position, force, std, unit)
    return measured_curve(form, weighing, words=f"missing force per unit mass {curve.where}".strip())


def measured_curve(
    curve: MeasuredCurve,
    weighing: Weighing,
    look: Look = LIGHT,
    words: str = "measured curve, per unit mass",
) -> Picture:
    """Draw a measured curve of a model, with two standard errors; `words` say what it is where no mass is known."""
    one = weighing.strength(Estimate(1.0, 0.0, curve.value_unit))
    value, band = one.value * curve.value, 2 * one.value * curve.std
    factor, name = scale_as_recorded("displacement" if curve.unit == "m" else "", curve.unit)
    drawn, (axis,) = figure(look, 2.4, width=4.2)
    axis.fill_between(curve.position * factor, value - band, value + band, color=look.noise, lw=0)
    axis.plot(curve.position * factor, value, color=look.second, lw=1.5)
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.set_xlabel(literal(f"{curve.over} [{name}]"))
    axis.set_ylabel(literal(f"{weighing.worded(words)}\n[{one.unit}] (band: 2 std. errors)"))
    return drawn


def curves(found: DecayCurves, names: Sequence[str], look: Look = LIGHT) -> Picture:
    """Draw frequency and damping against amplitude: releases as points with bands of two standard errors, laws as lines.

    `names` are the releases'.
    """
    drawn, axes = figure(look, 3.4, 1, 2)
    factor, unit = scale("displacement", found.unit)
    lines = {
        "usual": (look.ink, 0.9, ""),
        "named": (look.model, 2.2, "with "),
        "rival": (look.measured, 1.2, "or "),
    }
    for axis, (what, (label, _)) in zip(axes, PANELS.items(), strict=True):
        for place, curve in enumerate(found.releases):
            x, y, band = _values(curve, what)
            colour, mark = COLOURS[place % len(COLOURS)], MARKS[place % len(MARKS)]
            axis.fill_between(x * factor, y - band, y + band, color=colour, alpha=0.22, lw=0)
            axis.plot(
                x * factor, y, mark, color=colour, ms=4.2, mew=0.4, mec=axis.get_facecolor(), zorder=3,
                label=literal(names[curve.release]),
            )  # fmt: skip
        styles = {"usual": cycle("-"), "named": cycle("-"), "rival": cycle(RIVALS)}
        for laid in found.laws:
            colour, width, role = lines[laid.law.role]
            style, name = next(styles[laid.law.role]), literal(role + plain_name(laid.law.name))
            for curve, words in zip(laid.curves, (name, *"_" * len(laid.curves)), strict=False):
                x, y, _ = _values(curve, what)
                axis.plot(x * factor, y, style, color=colour, lw=width, label=words, zorder=2.5)
        axis.set(xlabel=literal(f"amplitude [{unit}]"), ylabel=label, ylim=_limits(what, found))
        axis.set_xlim(0.0, 1.04 * max(float(c.amplitude.max()) for c in found.releases) * factor)
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=8.5)
    return drawn


def _values(curve: AmplitudeCurve, what: str) -> tuple[Array, Array, Array]:
    """Take amplitude, values and two standard errors of a curve as a panel shows them, each (n,), by rising amplitude."""
    order, factor = np.argsort(curve.amplitude), PANELS[what][1]
    value, std = getattr(curve, what)[order], np.nan_to_num(getattr(curve, f"{what}_std")[order])
    return curve.amplitude[order], factor * value, BAND * factor * std


def _limits(what: str, found: DecayCurves) -> tuple[float, float]:
    """Return the range of a panel: of what each release shows well, and of the laws near it."""
    seen = []
    for curve in found.releases:
        _, values, band = _values(curve, what)
        known = band <= FAR * float(np.quantile(band, 0.25))
        seen += [(values - 0.5 * band)[known], (values + 0.5 * band)[known]]
    shown = np.concatenate(seen)
    bottom, top = float(shown.min()), float(shown.max())
    for law in (curve for laid in found.laws for curve in laid.curves):
        values = _values(law, what)[1]
        near = values[np.abs(values - 0.5 * (shown.min() + shown.max())) < np.ptp(shown)]
        bottom, top = float(np.min(near, initial=bottom)), float(np.max(near, initial=top))
    room = ROOM * (top - bottom) or 0.01 * max(abs(top), 1e-9)
    return bottom - room, top + room
