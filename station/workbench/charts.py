"""The charts of the middle as ECharts options: every axis with its unit, one colour for one thing."""

import json

from station.workbench import view_models
from station.workbench.chart_parts import (
    FONT,
    Options,
    base_options,
    grid_of,
    legend_of,
    line_series,
    pairs_of,
    time_axis,
    value_axis,
    with_bars,
)
from station.workbench.theme import Theme, diverging


def overlay(picture: view_models.Picture, trace: view_models.Trace, colours: Theme) -> Options:
    """Return measurement and model over time, with the band of the noise (2 std) about the model."""
    band = 2.0 * trace.sigma / trace.fine
    low = [None if value is None else round(value - band, 7) for value in trace.model]
    width = [None if value is None else round(2 * band, 7) for value in trace.model]
    hidden: Options = {"type": "line", "symbol": "none", "silent": True, "lineStyle": {"opacity": 0}}
    return base_options(colours) | {
        "grid": grid_of(bottom=20),
        "xAxis": time_axis(picture, colours, labelled=False),
        "yAxis": value_axis(f"{trace.channel} [{trace.unit}]", colours) | {"scale": True},
        "dataZoom": [_inside()],
        "series": [
            hidden | {"data": pairs_of(picture.time, low), "stack": "band", "stackStrategy": "all"},
            hidden
            | {
                "name": "noise (2 std)",
                "data": pairs_of(picture.time, width),
                "stack": "band",
                "stackStrategy": "all",
                "areaStyle": {"color": colours.noise, "opacity": 1},
                "itemStyle": {"color": colours.floor},
            },
            line_series("measured", picture.time, trace.measured, colours.measured, 2.6),
            line_series("model, run freely", picture.time, trace.model, colours.model, 1.2),
        ],
        "legend": legend_of(colours, ["measured", "model, run freely", "noise (2 std)"]),
    }


def residual(picture: view_models.Picture, trace: view_models.Trace, colours: Theme) -> Options:
    """Return measurement less model over time, with the band of the noise."""
    band = 2.0 * trace.sigma
    line = line_series("measured less model", picture.time, trace.left, colours.left, 1.0)
    line["markArea"] = {
        "silent": True,
        "itemStyle": {"color": colours.noise},
        "data": [[{"yAxis": -band}, {"yAxis": band}]],
    }
    return base_options(colours) | {
        "grid": grid_of(bottom=52),
        "xAxis": time_axis(picture, colours, labelled=True),
        "yAxis": value_axis(f"left over [{trace.fine_unit}]", colours),
        "dataZoom": [_inside(), _slider(colours)],
        "series": [line],
    }


def plane(picture: view_models.Picture, colours: Theme) -> Options:
    """Return the phase plane: the trajectory, and the missing force as colour where it is known."""
    forces = sorted(abs(one[4]) for one in picture.plane.bins)
    reach = forces[int(0.95 * (len(forces) - 1))] if forces else 1.0
    bins = [
        {"value": one, "itemStyle": {"color": diverging(one[4], reach, colours)}}
        for one in picture.plane.bins
    ]
    path = pairs_of(picture.displacement, picture.velocity)
    return base_options(colours) | {
        "grid": grid_of(left=58, bottom=34, right=64),
        "xAxis": value_axis(f"displacement [{picture.displacement_unit}]", colours, below=True),
        "yAxis": value_axis(f"velocity [{picture.velocity_unit}]", colours),
        "tooltip": {
            "trigger": "item",
            "renderMode": "richText",
            "confine": True,
            "textStyle": {"fontSize": FONT},
        },
        "visualMap": {
            "show": True,
            "type": "continuous",
            "seriesIndex": [],
            "min": -_round(reach),
            "max": _round(reach),
            "calculable": False,
            "right": 0,
            "top": 22,
            "itemHeight": 90,
            "itemWidth": 10,
            "text": [f"+{_round(reach):g}", f"-{_round(reach):g} {picture.force_unit}"],
            "textStyle": {"color": colours.faint, "fontSize": 10},
            "inRange": {"color": [diverging(x, 1.0, colours) for x in (-1.0, -0.5, 0.0, 0.5, 1.0)]},
        },
        "series": [
            {
                "type": "custom",
                "name": "missing force",
                "data": bins,
                "encode": {"x": [0, 1], "y": [2, 3]},
                "clip": True,
                ":renderItem": _RECTANGLE,
                "tooltip": {":formatter": _bin_words(picture.force_unit)},
            },
            {
                "type": "line",
                "data": path,
                "symbol": "none",
                "silent": True,
                "lineStyle": {"width": 0.5, "color": colours.faint, "opacity": 0.55},
            },
        ],
    }


_RECTANGLE = """(params, api) => {
  const a = api.coord([api.value(0), api.value(2)]), b = api.coord([api.value(1), api.value(3)]);
  return {type: 'rect', shape: {x: a[0], y: b[1], width: b[0] - a[0], height: a[1] - b[1]},
          style: {fill: api.visual('color')}};
}"""


def _bin_words(unit: str) -> str:
    """Return the script of a tooltip; the unit may be a stranger's, and so it enters as data."""
    written = json.dumps(f" {unit}")
    return (
        f"p => 'missing force: ' + p.value[4].toPrecision(3) + ' ± ' + p.value[5].toPrecision(2) + {written}"
    )


def sections(picture: view_models.Picture, colours: Theme) -> tuple[Options, Options]:
    """Return the cuts of the missing force: against velocity at u = 0, against displacement at v = 0."""
    found = picture.plane
    force = f"missing force [{picture.force_unit}]"
    at_middle = _section_chart(
        (found.middle,), f"velocity at u = 0 [{picture.velocity_unit}]", force, colours
    )
    at_rest = _section_chart(
        found.reversal, f"displacement at v = 0 [{picture.displacement_unit}]", force, colours
    )
    return at_middle, at_rest


def _section_chart(cuts: tuple[view_models.Section, ...], across: str, up: str, colours: Theme) -> Options:
    tints = (colours.left, colours.other)
    series: list[Options] = []
    for cut, tint in zip(cuts, tints, strict=False):
        series += with_bars(cut.name, cut.position, cut.force, cut.std, tint)
    legend = {"legend": legend_of(colours, [cut.name for cut in cuts])} if len(cuts) > 1 else {}
    return (
        base_options(colours)
        | legend
        | {
            "grid": grid_of(left=58, bottom=34),
            "xAxis": value_axis(across, colours, below=True),
            "yAxis": value_axis(up, colours),
            "series": series,
        }
    )


def cycles(picture: view_models.Picture, colours: Theme) -> tuple[Options, Options]:
    """Return the errors of frequency and of energy, cycle by cycle."""
    found = picture.cycles
    frequency = _cycle_chart(
        picture, found.frequency, found.frequency_std, "frequency error [%]", colours.left, colours
    )
    energy = _cycle_chart(
        picture, found.energy, found.energy_std, f"energy error [{found.energy_unit}]", colours.other, colours
    )
    return frequency, energy


def _cycle_chart(
    picture: view_models.Picture,
    values: view_models.Numbers,
    std: view_models.Numbers,
    name: str,
    tint: str,
    colours: Theme,
) -> Options:
    return base_options(colours) | {
        "grid": grid_of(left=58, bottom=34),
        "xAxis": time_axis(picture, colours, labelled=True),
        "yAxis": value_axis(name, colours),
        "series": with_bars(name, picture.cycles.time, values, std, tint),
    }


def _inside() -> Options:
    return {"type": "inside", "zoomOnMouseWheel": "ctrl", "moveOnMouseMove": True, "filterMode": "none"}


def _slider(colours: Theme) -> Options:
    return {
        "type": "slider",
        "height": 12,
        "bottom": 2,
        "showDetail": False,
        "showDataShadow": False,
        "brushSelect": False,
        "filterMode": "none",
        "borderColor": colours.grid,
        "textStyle": {"color": colours.faint},
    }


def _round(value: float) -> float:
    return float(f"{value:.2g}")
