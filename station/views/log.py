"""The parts of a viewer's tab: each function logs its data and returns the view that shows them."""

from collections.abc import Mapping, Sequence

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint.archetypes import PlotBackground

from identify.arrays import Array
from station.text.numbers import typeset
from station.views.figure import Picture

Colour = tuple[int, int, int]
Line = tuple[str, Array, Colour, float]
"""A curve: its name with its unit, its values, its colour, and how wide it is drawn."""

TIMELINE = "time"


def curves(
    stream: rr.RecordingStream,
    title: str,
    path: str,
    time: Array,
    lines: Mapping[str, Line],
    between: tuple[float, float] | None = None,
) -> rrb.View:
    """Log curves over the record's time in s, each under its key; a curve alone has none, and the title for a legend."""
    for key, (name, values, colour, width) in lines.items():
        place = f"{path}/{key}".rstrip("/")
        style = rr.SeriesLines(colors=colour, names=typeset(name), widths=width, aggregation_policy="MinMax")
        stream.log(place, style, static=True)
        stream.send_columns(
            place,
            indexes=[rr.TimeColumn(TIMELINE, duration=np.asarray(time, dtype=np.float64))],
            columns=rr.Scalars.columns(scalars=np.asarray(values, dtype=np.float64)),
        )
    return over_time(title, f"{path}/**", legend=len(lines) > 1, between=between)


def over_time(
    title: str, contents: str, *, legend: bool = True, between: tuple[float, float] | None = None
) -> rrb.View:
    """Return a view of curves over time, linked in time with the others, its legend at the top right."""
    return rrb.TimeSeriesView(
        origin="/",
        contents=[contents],
        name=typeset(title),
        axis_x=rrb.TimeAxis(link="LinkToGlobal"),
        axis_y=None if between is None else rrb.ScalarAxis(range=between),
        plot_legend=rrb.PlotLegend("RightTop", visible=legend),
        background=PlotBackground(show_grid=True),
    )


def picture(stream: rr.RecordingStream, title: str, path: str, drawn: Picture) -> rrb.View:
    """Log a picture with real axes, on a ground of its own: the viewer draws nothing through it."""
    contents = drawn.encoded("png", facecolor=drawn.look.paper)
    stream.log(path, rr.EncodedImage(contents=contents, media_type="image/png"), static=True)
    return rrb.Spatial2DView(origin=path, contents=[path], name=title)


def markdown(stream: rr.RecordingStream, title: str, path: str, text: str) -> rrb.View:
    """Log a text."""
    stream.log(path, rr.TextDocument(text, media_type="text/markdown"), static=True)
    return rrb.TextDocumentView(origin=path, contents=[path], name=title)


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
