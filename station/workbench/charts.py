"""The charts of the details as ECharts options: every axis with its unit, one colour for one thing."""

from station.workbench import view_models
from station.workbench.chart_parts import (
    Options,
    base_options,
    grid_of,
    legend_of,
    time_axis,
    value_axis,
    with_bars,
)
from station.workbench.theme import Theme


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
