"""The charts of the curves: frequency and damping against amplitude, several releases and models in one."""

import math

from station.workbench import view_models
from station.workbench.chart_parts import (
    Options,
    axis_options,
    base_options,
    grid_of,
    legend_of,
    line_series,
    value_axis,
    with_bars,
)
from station.workbench.theme import Theme

SYMBOLS = ("circle", "rect", "triangle", "diamond")
LINE_OF_KEYS = 62
KEY = 5
FIGURES = 5
"""To which an axis' ends are rounded, of its reach."""


def decay_curves(found: view_models.DecayCurves, colours: Theme) -> tuple[Options, Options]:
    """Return frequency and damping against amplitude: releases as points with two standard errors, models as lines.

    The legend of the first chart names the models, that of the second the releases.
    """
    models = _names(found, measured=False)
    releases = _names(found, measured=True)
    frequency: list[Options] = []
    damping: list[Options] = []
    for one in found.lines:
        for series, values, std in (
            (frequency, one.frequency, one.frequency_std),
            (damping, one.damping, one.damping_std),
        ):
            if one.role == "measured":
                series += _points(one, values, std, releases.index(one.name), colours)
            else:
                series.append(_model(one, values, models[-1], colours))
    rows = max(_rows(models), _rows(releases))
    return (
        _chart(found, "frequency [Hz]", found.frequency_range, frequency, (models, rows), colours),
        _chart(found, "damping ratio [%]", found.damping_range, damping, (releases, rows), colours),
    )


def _names(found: view_models.DecayCurves, *, measured: bool) -> list[str]:
    return list(dict.fromkeys(one.name for one in found.lines if (one.role == "measured") == measured))


def _points(
    one: view_models.AmplitudeLine,
    values: view_models.Numbers,
    std: view_models.Numbers,
    place: int,
    colours: Theme,
) -> list[Options]:
    tints = (colours.left, colours.other, colours.floor, colours.measured)
    bars, points = with_bars(one.name, one.amplitude, values, std, tints[place % len(tints)])
    return [bars, points | {"symbol": SYMBOLS[place % len(SYMBOLS)], "lineStyle": {"width": 0}}]


def _model(one: view_models.AmplitudeLine, values: view_models.Numbers, last: str, colours: Theme) -> Options:
    """Return a model's line: the usual one thin, the named one thick, its rivals broken, the last of them dotted."""
    styles = {
        "usual": (1.2, "solid", colours.measured),
        "named": (2.6, "solid", colours.model),
        "rival": (1.6, "dotted" if one.name == last else "dashed", colours.faint),
    }
    width, dash, tint = styles[one.role]
    drawn = line_series(one.name, one.amplitude, values, tint, width)
    drawn["lineStyle"]["type"] = dash
    return drawn


def _rows(names: list[str]) -> int:
    """Return in how many rows a legend stands in a narrow chart, by its letters."""
    rows, used = 1, 0
    for name in names:
        if used and used + len(name) + KEY > LINE_OF_KEYS:
            rows, used = rows + 1, 0
        used += len(name) + KEY
    return rows


def _chart(
    found: view_models.DecayCurves,
    name: str,
    between: tuple[float, float],
    series: list[Options],
    keys: tuple[list[str], int],
    colours: Theme,
) -> Options:
    """Return one of the two charts; its legend, `keys` in some rows, stands above the name of the axis."""
    low, high = between
    places = FIGURES - math.floor(math.log10(max(high - low, 1e-12)))  # of the reach: no end at -7.51e-17
    ends = {"min": round(low, places), "max": round(high, places)}
    labels = axis_options(colours)["axisLabel"] | {"showMinLabel": False, "showMaxLabel": False}
    return base_options(colours) | {
        "grid": grid_of(left=58, bottom=34, top=24 + 17 * keys[1]),
        "legend": legend_of(colours, keys[0]) | {"top": 2, "left": 8, "right": 8, "itemGap": 8},
        "xAxis": value_axis(f"amplitude [{found.unit}]", colours, below=True) | {"min": 0, "scale": False},
        "yAxis": value_axis(name, colours) | ends | {"axisLabel": labels},
        "series": [one | {"clip": True} for one in series],
    }
