"""Pictures with real axes and units: one drawing for report, page, viewer and notebook, in light or dark colours."""

import base64
import re
from contextlib import AbstractContextManager
from io import BytesIO
from typing import Any

from identify.arrays import Array
from station.text.numbers import typeset
from station.views.palette import LIGHT, Look
from station.working_folder import unseen

with unseen("matplotlibrc"):
    import matplotlib

# isort: split
from matplotlib.axes import Axes as Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import LinearSegmentedColormap as LinearSegmentedColormap
from matplotlib.figure import Figure

WIDTH = 6.9
_PATH = re.compile(rb'\bd="[^"]*"')
_DECIMALS = re.compile(rb"(\.\d\d)\d+")  # a hundredth of a point is finer than any printer

STYLE: dict[Any, Any] = {
    "axes.facecolor": "none",
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.linewidth": 0.7,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "font.size": 8.5,
    "lines.linewidth": 1.0,
    "path.simplify_threshold": 0.3,  # points: a long record has far more samples than can be seen
    "legend.fontsize": 8,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "font.sans-serif": ["Liberation Sans", "Arial", "Helvetica", "DejaVu Sans"],
    "svg.hashsalt": "report",
}
_INKED = ("axes.labelcolor", "axes.titlecolor", "text.color", "xtick.color", "ytick.color")


def inked(look: Look) -> AbstractContextManager[None]:
    """Draw in the colours of a look, within a `with`; what is written in them later needs them again."""
    inks = dict.fromkeys(_INKED, look.ink) | {"axes.edgecolor": look.faint, "grid.color": look.faint}
    return matplotlib.rc_context(STYLE | inks | {"figure.facecolor": look.paper})


class Picture(Figure):
    """A figure that a notebook shows by itself; `savefig` writes it to a file."""

    look = LIGHT

    def encoded(self, form: str, **how: Any) -> bytes:
        """Return the picture as "png" or "svg"; its ticks are made now, in its own colours."""
        buffer = BytesIO()
        with inked(self.look):
            self.savefig(buffer, format=form, **how)
        return buffer.getvalue()

    def _repr_png_(self) -> bytes:
        return self.encoded("png", dpi=110)

    @property
    def uri(self) -> str:
        """The picture as a data URI of an SVG: nothing outside a page is needed to see it."""
        buffer = BytesIO()
        with inked(self.look):  # not `savefig`, which would draw it twice
            FigureCanvasSVG(self).print_svg(buffer, metadata={"Date": None})  # type: ignore[no-untyped-call]
        small = _PATH.sub(lambda path: _DECIMALS.sub(rb"\1", path.group()), buffer.getvalue())
        return f"data:image/svg+xml;base64,{base64.b64encode(small).decode()}"


def figure(
    look: Look, height: float, rows: int | str = 1, columns: int = 1, width: float = WIDTH, **how: Any
) -> tuple[Picture, list[Axes]]:
    """Return a picture of that size in inches and its axes in reading order; `how` goes to matplotlib's `subplots`.

    `rows` may be a mosaic, as "aa;bc" for a wide pair of axes over two others.
    """
    with inked(look):
        made = Picture(figsize=(width, height), dpi=150, layout="constrained")
        if isinstance(rows, str):
            axes = list(made.subplot_mosaic(rows, **how).values())
        else:
            axes = list(made.subplots(rows, columns, squeeze=False, **how).ravel())
    made.look = look
    return made, axes


def literal(text: str) -> str:
    """Return text that matplotlib draws as it stands, whatever signs a stranger's names hold."""
    return typeset(text).replace("$", r"\$")


def zero_lines(axis: Axes, look: Look) -> None:
    """Draw the axes through zero."""
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.axvline(0, color=look.faint, lw=0.7)


def points(
    axis: Axes, x: Array, y: Array, std: Array | None, form: str, colour: str, label: str = ""
) -> None:
    """Draw points with two standard errors, where those are known; `form` as matplotlib takes it."""
    error = None if std is None else 2 * std
    axis.errorbar(x, y, yerr=error, fmt=form, ms=3.5, lw=0.9, capsize=2, color=colour, label=label or None)
