"""Frequency and damping against amplitude: two panels that viewer, report and notebook share."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import AmplitudeCurve
from identify.curves.laid_over import DecayCurves, LaidOver
from identify.formatting import plain_name
from station.text.numbers import scale
from station.views.figure import literal
from station.views.palette import Look

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = ("#0072b2", "#b35900", "#00795a", "#a0527f", "#6b6b00", "#444444")
MARKS = ("o", "s", "^", "v", "D", "P")
WIDTHS = {"usual": 0.9, "named": 2.2, "rival": 1.2}
RIVALS = ("--", ":")
DAMPING = "damping ratio [%]"
FREQUENCY = "frequency [Hz]"
FAR = 4.0
ROOM = 0.06
BAND = 2.0


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


def draw_panels(axes: Sequence["Axes"], found: DecayCurves, names: Sequence[str], look: Look) -> None:
    """Draw releases as points with bands of two standard errors, laws as lines; `names` are the releases'."""
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
        axis.set_ylim(*limits(panel, found))
        axis.set_xlim(0.0, 1.04 * max(float(c.amplitude.max()) for c in found.releases) * factor)
        axis.ticklabel_format(axis="y", useOffset=False)
    handles, labels = axes[0].get_legend_handles_labels()
    axes[0].figure.legend(
        handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=8.5, labelcolor=look.ink
    )


def _release(
    axis: "Axes", panel: Panel, curve: AmplitudeCurve, factor: float, look: tuple[str, str], name: str
) -> None:
    colour, mark = look
    edge = axis.get_facecolor()
    order = np.argsort(curve.amplitude)
    x, y, band = (
        values[order] for values in (curve.amplitude * factor, panel.values(curve), panel.band(curve))
    )
    axis.fill_between(x, y - band, y + band, color=colour, alpha=0.22, lw=0)
    axis.plot(x, y, mark, color=colour, ms=4.2, mew=0.4, mec=edge, zorder=3, label=literal(name))


def _law(axis: "Axes", panel: Panel, laid: LaidOver, factor: float, look: Look, style: str) -> None:
    colour = (
        look.model if laid.law.role == "named" else look.ink if laid.law.role == "usual" else look.measured
    )
    for number, curve in enumerate(laid.curves):
        order = np.argsort(curve.amplitude)
        axis.plot(curve.amplitude[order] * factor, panel.values(curve)[order], style, color=colour,
                  lw=WIDTHS[laid.law.role], label=literal(label(laid)) if number == 0 else "_", zorder=2.5)  # fmt: skip


def label(laid: LaidOver) -> str:
    """Say how a law is called in a legend."""
    name = plain_name(laid.law.name)
    return {"usual": name, "named": f"with {name}", "rival": f"or {name}"}[laid.law.role]


def limits(panel: Panel, found: DecayCurves) -> tuple[float, float]:
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
