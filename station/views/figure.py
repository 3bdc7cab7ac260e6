"""Pictures with real axes and units, in ink that stands out from a light and from a dark ground."""

from typing import TYPE_CHECKING, Any, Literal

from station.views import palette
from station.working_folder import unseen

with unseen("matplotlibrc"):
    import matplotlib as matplotlib

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DOTS_PER_INCH = 150

STYLE: dict[Any, Any] = {
    "figure.facecolor": "white",
    "axes.facecolor": "none",
    "axes.edgecolor": palette.FAINT,
    "axes.labelcolor": palette.INK,
    "axes.titlecolor": palette.INK,
    "axes.titlesize": 11,
    "axes.labelsize": 10,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": palette.FAINT,
    "grid.alpha": 0.35,
    "grid.linewidth": 0.6,
    "text.color": palette.INK,
    "xtick.color": palette.INK,
    "ytick.color": palette.INK,
    "xtick.labelsize": 9,
    "ytick.labelsize": 9,
    "font.size": 10,
}


def figure(
    width: float,
    height: float,
    rows: int = 1,
    columns: int = 1,
    sharey: bool = False,
    style: dict[Any, Any] = STYLE,
    **grid: Any,
) -> tuple["Figure", list["Axes"]]:
    """Return a figure of that size in inches and its axes in reading order.

    `style` is the viewer's unless another is given; `grid` goes to matplotlib's `subplots` (sharex, height_ratios ...).
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(style):
        made = Figure(figsize=(width, height), dpi=DOTS_PER_INCH, layout="constrained")
        FigureCanvasAgg(made)
        axes = made.subplots(rows, columns, squeeze=False, sharey=sharey, **grid)
    return made, list(axes.ravel())


def legend(
    axis: "Axes",
    place: Literal["upper left", "upper right", "lower left"],
    labels: list[str] | None = None,
    colour: str = palette.INK,
) -> None:
    """Put a legend without a box at `place`; `labels` name the curves in the order in which they were drawn."""
    for handle, label in zip(axis.get_lines(), labels or [], strict=False):
        handle.set_label(label)
    axis.legend(loc=place, frameon=False, labelcolor=colour, fontsize=9)
