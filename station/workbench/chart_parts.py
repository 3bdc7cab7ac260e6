"""What the charts of the page are put together from: axes with units, grids, legends, lines, points with bars."""

from typing import Any

from station.workbench import view_models
from station.workbench.theme import Theme

Options = dict[str, Any]

FONT = 11


def with_bars(
    name: str, across: view_models.Numbers, values: view_models.Numbers, std: view_models.Numbers, tint: str
) -> list[Options]:
    """Return points with bars of two standard errors."""
    known = [(x, y, s) for x, y, s in zip(across, values, std, strict=True) if None not in (x, y, s)]
    bars = [
        [x, y - 2 * s, y + 2 * s] for x, y, s in known if x is not None and y is not None and s is not None
    ]
    return [
        {
            "type": "custom",
            "data": bars,
            "encode": {"x": 0, "y": [1, 2]},
            "silent": True,
            "itemStyle": {"color": tint},
            ":renderItem": _BAR,
        },
        {
            "type": "line",
            "name": name,
            "data": [[x, y] for x, y, _ in known],
            "symbol": "circle",
            "symbolSize": 5,
            "lineStyle": {"width": 1, "opacity": 0.5, "color": tint},
            "itemStyle": {"color": tint},
            "silent": True,
        },
    ]


_BAR = """(params, api) => {
  const a = api.coord([api.value(0), api.value(1)]), b = api.coord([api.value(0), api.value(2)]);
  return {type: 'line', shape: {x1: a[0], y1: a[1], x2: b[0], y2: b[1]},
          style: {stroke: api.visual('color'), lineWidth: 1.5, opacity: 0.7}};
}"""


def base_options(colours: Theme) -> Options:
    """Make the options that every chart begins with."""
    return {
        "animation": False,
        "backgroundColor": "transparent",
        "textStyle": {"color": colours.ink, "fontFamily": "inherit"},
    }


def grid_of(left: int = 58, right: int = 14, top: int = 24, bottom: int = 26) -> Options:
    """Return the room about a chart, pixels."""
    return {"left": left, "right": right, "top": top, "bottom": bottom}


def axis_options(colours: Theme) -> Options:
    """Return an axis of values, without a name."""
    return {
        "type": "value",
        "axisLine": {"show": True, "onZero": False, "lineStyle": {"color": colours.faint}},
        "axisLabel": {"color": colours.faint, "fontSize": FONT, "hideOverlap": True},
        "splitLine": {"lineStyle": {"color": colours.grid}},
        "nameTextStyle": {"color": colours.ink, "fontSize": FONT},
    }


def time_axis(picture: view_models.Picture, colours: Theme, labelled: bool) -> Options:
    """Return the axis of time over the whole record."""
    label = axis_options(colours)["axisLabel"] | {"showMaxLabel": False}
    known = [t for t in picture.time if t is not None] or [0.0, 1.0]
    first, last = known[0], known[-1]
    named = (
        {"name": "time since the release [s]", "nameLocation": "middle", "nameGap": 20} if labelled else {}
    )
    return (
        axis_options(colours)
        | named
        | {
            "min": 0 if first < 0.25 * (last - first) else round(first, 3),
            "max": round(last, 3),
            "axisLabel": label,
        }
    )


def value_axis(name: str, colours: Theme, below: bool = False) -> Options:
    """Return an axis with its name, across (`below`) or up."""
    place: Options = (
        {"nameLocation": "middle", "nameGap": 20} if below else {"nameLocation": "end", "nameGap": 8}
    )
    if not below:
        place["nameTextStyle"] = {
            "color": colours.ink,
            "fontSize": FONT,
            "align": "left",
            "padding": [0, 0, 0, -44],
        }
    return axis_options(colours) | {"name": name, "splitNumber": 4, "scale": below} | place


def line_series(
    name: str, across: view_models.Numbers, values: view_models.Numbers, colour: str, width: float
) -> Options:
    """Return a line without points."""
    return {
        "name": name,
        "type": "line",
        "symbol": "none",
        "silent": True,
        "data": pairs_of(across, values),
        "lineStyle": {"width": width, "color": colour},
        "itemStyle": {"color": colour},
    }


def pairs_of(across: view_models.Numbers, values: view_models.Numbers) -> list[list[float | None]]:
    """Return points, None where there is a hole."""
    return [[x, y] for x, y in zip(across, values, strict=True)]


def legend_of(colours: Theme, names: list[str]) -> Options:
    """Return a legend at the top right."""
    return {
        "data": names,
        "right": 10,
        "top": 0,
        "icon": "roundRect",
        "itemWidth": 16,
        "itemHeight": 4,
        "textStyle": {"color": colours.ink, "fontSize": FONT},
    }
