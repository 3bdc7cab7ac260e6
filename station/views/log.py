"""The few ways in which numbers are put into a Rerun recording."""

from collections.abc import Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray
from rerun.blueprint.archetypes import PlotBackground

from station.text.numbers import typeset
from station.views import palette
from station.views.figure import Picture

Array = NDArray[np.float64]
Colour = tuple[int, int, int]

TIMELINE = "time"


def series(
    stream: rr.RecordingStream,
    path: str,
    time: Array,
    values: Array,
    name: str,
    colour: Colour,
    width: float = 1.5,
) -> None:
    """Log a curve over the record's time in s; the name carries the unit."""
    style = rr.SeriesLines(colors=colour, names=typeset(name), widths=width, aggregation_policy="MinMax")
    stream.log(path, style, static=True)
    stream.send_columns(
        path,
        indexes=[rr.TimeColumn(TIMELINE, duration=np.asarray(time, dtype=np.float64))],
        columns=rr.Scalars.columns(scalars=np.asarray(values, dtype=np.float64)),
    )


def picture(stream: rr.RecordingStream, path: str, drawn: Picture) -> None:
    """Log a picture with real axes, on the ground of the viewer."""
    contents = drawn.encoded("png", facecolor=palette.ground.get())
    stream.log(path, rr.EncodedImage(contents=contents, media_type="image/png"), static=True)


def markdown(stream: rr.RecordingStream, path: str, text: str) -> None:
    """Log a text."""
    stream.log(path, rr.TextDocument(text, media_type="text/markdown"), static=True)


def curves(name: str, contents: list[str], between: tuple[float, float] | None = None) -> rrb.View:
    """Return a view of curves over time, linked in time with the others, its legend at the top right."""
    return _over_time(name, contents, between, legend=True)


def curve(name: str, path: str, between: tuple[float, float] | None = None) -> rrb.View:
    """Return a view of one curve over time; the name of the view carries its unit in place of a legend."""
    return _over_time(name, [path], between, legend=False)


def _over_time(name: str, contents: list[str], between: tuple[float, float] | None, legend: bool) -> rrb.View:
    axis = None if between is None else rrb.ScalarAxis(range=between)
    return rrb.TimeSeriesView(
        origin="/",
        contents=contents,
        name=typeset(name),
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        axis_y=axis,
        plot_legend=rrb.PlotLegend("RightTop", visible=legend),
        background=PlotBackground(show_grid=True),
    )


def blueprint(tabs: Sequence[rrb.Container], *, active: int = 0, follow: bool = False) -> rrb.Blueprint:
    """Return a layout of tabs with the panels out of the way; `follow` keeps to the newest sample."""
    play_state = {"play_state": "Following"} if follow else {}
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=active),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, **play_state),
        auto_views=False,
        auto_layout=False,
    )


def shown_picture(name: str, path: str) -> rrb.View:
    """Return a view of one picture."""
    return rrb.Spatial2DView(origin=path, contents=[path], name=name)


def document(name: str, path: str) -> rrb.View:
    """Return a view of one text."""
    return rrb.TextDocumentView(origin=path, contents=[path], name=name)
