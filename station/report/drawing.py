"""Pictures for paper: dark ink on white, curves distinguishable without colour, kept in the page itself."""

import base64
import re
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from identify.arrays import Array
from station.views.figure import figure
from station.views.plots import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH = 6.9
INK, GREY, BAND, MODEL, OTHER = PAPER.ink, PAPER.faint, PAPER.noise, PAPER.model, "#a63603"
MOST_POINTS = 900
_PATH = re.compile(rb'\bd="[^"]*"')
_DECIMALS = re.compile(rb"(\.\d\d)\d+")  # a hundredth of a point is finer than any printer

STYLE: dict[Any, Any] = {
    "figure.facecolor": "white",
    "axes.facecolor": "white",
    "axes.edgecolor": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "grid.color": "#dddddd",
    "grid.alpha": 1.0,
    "grid.linewidth": 0.5,
    "text.color": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "font.size": 8.5,
    "lines.linewidth": 1.0,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "font.sans-serif": ["Liberation Sans", "Arial", "Helvetica", "DejaVu Sans"],
    "savefig.dpi": 150,
    "svg.hashsalt": "report",
}


def paper(
    height: float, rows: int = 1, columns: int = 1, width: float = WIDTH, **how: Any
) -> tuple["Figure", list["Axes"]]:
    """Return a figure for paper and its axes in reading order; sizes in inches."""
    return figure(width, height, rows, columns, style=STYLE, **how)


def joined(drawn: "Figure", cells: list["Axes"]) -> "Axes":
    """Return one pair of axes in place of several neighbouring ones."""
    places = [cell.get_subplotspec() for cell in cells]
    first, last = places[0], places[-1]
    assert first is not None
    assert last is not None
    for cell in cells:
        cell.remove()
    rows = slice(first.rowspan.start, last.rowspan.stop)
    columns = slice(first.colspan.start, last.colspan.stop)
    made: Axes = drawn.add_subplot(first.get_gridspec()[rows, columns])
    return made


def embedded(drawn: "Figure") -> str:
    """Return a figure as a data URI of an SVG: nothing outside the page is needed to see it."""
    buffer = BytesIO()
    drawn.savefig(buffer, format="svg", metadata={"Date": None})
    drawing = _PATH.sub(lambda path: _DECIMALS.sub(rb"\1", path.group()), buffer.getvalue())
    return f"data:image/svg+xml;base64,{base64.b64encode(drawing).decode()}"


def thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve with at most `MOST_POINTS` points that keeps the extremes of every stretch; holes stay holes."""
    time, values = np.asarray(time, dtype=float), np.asarray(values, dtype=float)
    size = -(-len(time) // (MOST_POINTS // 2))
    if size <= 2:
        return time, values
    kept = []
    for first in range(0, len(time), size):
        block = values[first : first + size]
        if np.isfinite(block).any():
            kept += sorted({first + int(np.nanargmin(block)), first + int(np.nanargmax(block))})
        else:
            kept.append(first)
    return time[kept], values[kept]


def curve(axis: "Axes", time: Array, values: Array, **how: Any) -> None:
    """Draw a curve, thinned to what paper can show."""
    axis.plot(*thinned(time, values), **how)


def both(axis: "Axes", time: Array, measured: Array, model: Array, names: tuple[str, str]) -> None:
    """Draw a measurement as a broad grey line and a model as a thin dark one over it."""
    curve(axis, time, measured, color="#b5b5b5", lw=2.4, label=names[0], solid_capstyle="round")
    curve(axis, time, model, color=MODEL, lw=0.8, label=names[1])
