"""The Compare tab: measurement and model, what is left beside the noise, the phase plane, the errors cycle by cycle."""

from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.formatting import plain_name
from station.story.compared import Compared
from station.story.residual import floor_words, times
from station.text.numbers import energy_scale, scale, three_figures
from station.views import log, palette, plots
from station.views.figure import figure, legend
from station.views.log import Array
from station.views.plots import SCREEN, literal

ROOT = "/compare"
NAME = "Compare"
BAND = 2.0
FORCE_HEIGHT = 0.7


def write_file(file: Path, compared: Compared) -> None:
    """Write a recording that holds this tab alone."""
    from station.views.show import APPLICATION

    stream = rr.RecordingStream(APPLICATION, send_properties=False)
    stream.save(file, default_blueprint=log.blueprint([tab(compared)]))
    write(stream, compared)
    stream.flush()
    stream.disconnect()


def write(stream: rr.RecordingStream, compared: Compared, root: str = ROOT) -> None:
    """Log a comparison under `root`; another model goes under another root, as logged times cannot be replaced."""
    log.markdown(stream, f"{root}/summary", summary(compared))
    for channel in compared.baseline.fit.windows[0].channels:
        _channel(stream, compared, channel, root)
    _phase_plane(stream, compared, root)
    _sections(stream, compared, root)
    _cycles(stream, compared, root)


def _channel(stream: rr.RecordingStream, compared: Compared, channel: str, root: str) -> None:
    fit = compared.baseline.fit
    window = fit.windows[0]
    factor, unit = scale(channel, window.unit)
    used = window.used[channel]
    time = compared.comparison.time[used]
    measured = window.readings[channel][used] * factor
    model = fit.predicted[0][channel][used] * factor
    log.series(
        stream, f"{root}/{channel}/measured", time, measured, f"measured [{unit}]", palette.MEASURED, 4.5
    )
    log.series(
        stream, f"{root}/{channel}/model", time, model, f"model, run freely [{unit}]", palette.FORCE, 1.5
    )
    fine, fine_unit = scale(channel, window.unit, fine=True)
    left = fit.residual(channel)[used] * fine
    noise = BAND * window.sigma[channel] * fine
    log.series(
        stream,
        f"{root}/{channel}_left/residual",
        time,
        left,
        f"measured less model [{fine_unit}]",
        palette.WRONG,
        1.2,
    )
    for name, level in (("above", noise), ("below", -noise)):
        band = np.full(len(time), level)
        log.series(
            stream,
            f"{root}/{channel}_left/{name}",
            time,
            band,
            f"noise, 2 std [{fine_unit}]",
            palette.REFERENCE,
            1.0,
        )


def _phase_plane(stream: rr.RecordingStream, compared: Compared, root: str) -> None:
    """Log each bin of the phase plane as a column whose height and colour are the force that the model lacks."""
    found = compared.comparison
    plane, units = found.phase_plane, DiscrepancyText(found.unit, found.mass)
    rows, columns = plane.bins[:, 0], plane.bins[:, 1]
    force = plane.force[rows, columns]
    score = plane.significance[rows, columns]
    tallest = max(float(np.max(np.abs(force))), 1e-300)
    reach = np.array([plane.displacement_edges[-1], plane.velocity_edges[-1]])
    centre = np.column_stack([plane.displacement[columns] / reach[0], plane.velocity[rows] / reach[1]])
    height = force / tallest * FORCE_HEIGHT
    half = np.array([1.0 / plane.force.shape[1], 1.0 / plane.force.shape[0]]) * 0.92
    stream.log(
        f"{root}/plane/force",
        rr.Boxes3D(
            centers=np.column_stack([centre, height / 2.0]),
            half_sizes=np.column_stack([np.broadcast_to(half, centre.shape), np.abs(height) / 2.0 + 0.002]),
            colors=_colours(force / tallest, np.abs(score)),
            fill_mode="Solid",
        ),
        static=True,
    )
    path = np.column_stack(
        [found.displacement / reach[0], found.velocity / reach[1], np.zeros(len(found.time))]
    )
    stream.log(
        f"{root}/plane/motion", rr.LineStrips3D([path], colors=palette.REFERENCE, radii=0.003), static=True
    )
    labels = [
        f"displacement ± {units.length(float(reach[0]))} {units.length_unit}",
        f"velocity ± {reach[1]:.3g} {found.unit}/s",
        f"measured less model, ± {tallest * units.force_scale:.2g} {units.force_unit}",
    ]
    axes = [
        [[-1, -1, 0], [1, -1, 0]],
        [[1, -1, 0], [1, 1, 0]],
        [[-1, -1, -FORCE_HEIGHT], [-1, -1, FORCE_HEIGHT]],
    ]
    colours = [palette.DISPLACEMENT, palette.VELOCITY, palette.ACCELERATION]
    stream.log(f"{root}/plane/axes", rr.LineStrips3D(axes, colors=colours, radii=0.006), static=True)
    ends = [[0, -1.15, 0], [1.15, 0.1, 0], [-1, -1, FORCE_HEIGHT + 0.1]]
    stream.log(
        f"{root}/plane/names",
        rr.Points3D(ends, labels=labels, colors=colours, radii=0.008, show_labels=True),
        static=True,
    )
    stream.log(
        f"{root}/plane/numbers",
        rr.AnyValues(
            displacement=plane.displacement[columns],
            velocity=plane.velocity[rows],
            force_per_mass=force,
            std=plane.std[rows, columns],
            counts=plane.counts[rows, columns],
        ),
        static=True,
    )


def _colours(share: Array, score: Array) -> Array:
    """Red where the measured force is larger, blue where smaller, grey where that is within the noise."""
    import matplotlib

    table = matplotlib.colormaps["coolwarm"]((np.clip(share, -1, 1) + 1) / 2)
    grey = np.array([0.35, 0.38, 0.42, 1.0])
    sure = np.clip((score - 2.0) / 2.0, 0.0, 1.0)[:, None]
    colours: Array = ((sure * table + (1.0 - sure) * grey) * 255).astype(np.uint8)
    return colours


def _sections(stream: rr.RecordingStream, compared: Compared, root: str) -> None:
    found = compared.comparison
    units = DiscrepancyText(found.unit, found.mass)
    factor, length = scale("displacement", found.unit)
    drawn, axes = figure(4.8, 5.6, 2, 1)
    down, up = found.phase_plane.sections_at_reversal
    middle = found.phase_plane.section_at_middle
    plots.missing_section(axes[0], up, factor, units, SCREEN, "^-", "moving to the positive side")
    plots.missing_section(axes[0], down, factor, units, SCREEN, "v--", "moving to the negative side")
    plots.missing_section(axes[1], middle, 1.0, units, SCREEN, "o-", "")
    axes[0].set(xlabel=literal(f"displacement [{length}]"), title="at velocity 0: stiffness, 2 std")
    axes[1].set(xlabel=literal(f"velocity [{found.unit}/s]"), title="at displacement 0: damping, 2 std")
    for axis in axes:
        axis.set_ylabel(literal(f"measured less model [{units.force_unit}]"))
    legend(axes[0], "upper left")
    numbers = {
        "u": up.position,
        "force_up": up.force,
        "force_down": down.force,
        "v": middle.position,
        "force_middle": middle.force,
    }
    log.picture(stream, f"{root}/sections", drawn, numbers)


def _cycles(stream: rr.RecordingStream, compared: Compared, root: str) -> None:
    found = compared.comparison
    units, done = DiscrepancyText(found.unit, found.mass), found.cycles
    factor, length = scale("displacement", found.unit)
    drawn, axes = figure(4.8, 5.6, 2, 1)
    energy_factor, energy_unit = energy_scale(units)
    rows = (
        (done.frequency_error, done.frequency_error_std, 1.0, "frequency error [%]", "stiffness"),
        (
            done.energy_error,
            done.energy_error_std,
            energy_factor,
            f"energy error a cycle [{energy_unit}]",
            "damping",
        ),
    )
    for axis, (values, std, per_si, label, title) in zip(axes, rows, strict=True):
        plots.cycle_by_cycle(axis, done.amplitude * factor, values * per_si, std * per_si, SCREEN)
        axis.set(
            xlabel=literal(f"amplitude of the cycle [{length}]"),
            ylabel=literal(label),
            title=f"{title}, 2 std",
        )
    numbers = {
        "amplitude": done.amplitude,
        "frequency_error": done.frequency_error,
        "energy_error": done.energy_error,
    }
    log.picture(stream, f"{root}/cycles", drawn, numbers)


def summary(compared: Compared) -> str:
    """Return the errors and the worst places as markdown."""
    found, error = compared.comparison, compared.error
    names = " + ".join(plain_name(name) for name in compared.baseline.fit.model.names)
    lines = [
        f"**{compared.name}** against {compared.words}: {names}",
        "",
        f"| residual of a free run of {three_figures(error.horizon_s)} s | value | noise alone |",
        "|---|---:|---:|",
        f"| % of the motion | {three_figures(error.motion_percent)} | {three_figures(compared.motion_floor)} |",
        f"| times the noise | {times(error.chi_square)} | {floor_words(error.floor_std)} |",
        "",
        found.cause,
        "",
        *([compared.one_run, ""] if compared.one_run else []),
    ]
    if not found.places:
        lines.append(f"**{found.summary}**")
    lines += [
        f"{i}. {place.text} ({place.significance:.0f} sigma)" for i, place in enumerate(found.places, start=1)
    ]
    return "\n".join(lines)


def _range(values: Array) -> tuple[float, float]:
    low, high = float(np.min(values)), float(np.max(values))
    room = 0.06 * max(high - low, 1e-300)
    return low - room, high + room


def tab(compared: Compared, root: str = ROOT) -> rrb.Container:
    """Return the layout of the tab."""
    fit = compared.baseline.fit
    channels = fit.windows[0].channels
    views = []
    for channel in channels:
        used = fit.windows[0].used[channel]
        reading = fit.windows[0].readings[channel][used] * scale(channel, fit.windows[0].unit)[0]
        left = fit.residual(channel)[used] * scale(channel, fit.windows[0].unit, fine=True)[0]
        views.append(
            log.curves(
                f"{channel.capitalize()}: measured, and the model run freely",
                [f"{root}/{channel}/**"],
                _range(reading),
            )
        )
        views.append(
            log.curves(
                f"What is left of the {channel}, and the noise", [f"{root}/{channel}_left/**"], _range(left)
            )
        )
    plane = rrb.Spatial3DView(
        origin=f"{root}/plane",
        name="Phase plane: the force that the model lacks (grey: within the noise)",
        background=palette.BACKGROUND,
        line_grid=False,
        eye_controls=rrb.EyeControls3D(
            position=(-1.35, -2.5, 1.5), look_target=(0.05, 0.0, -0.1), eye_up=(0.0, 0.0, 1.0)
        ),
    )
    return rrb.Horizontal(
        rrb.Vertical(log.document("Comparison", f"{root}/summary"), plane, row_shares=[1, 1.2]),
        rrb.Vertical(*views, row_shares=[1.0, 0.8] * len(channels)),
        rrb.Vertical(
            log.shown_picture("Sections through the phase plane", f"{root}/sections"),
            log.shown_picture("Cycle by cycle", f"{root}/cycles"),
        ),
        column_shares=[1.1, 1.1, 0.8],
        name=NAME,
    )
