"""Where a model fails, in figures: measurement and model, the phase plane, cycle by cycle."""

from collections.abc import Sequence

import numpy as np

from identify.comparison.compare import Comparison
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.fitting.fit import Fit
from station.text.numbers import energy_scale, scale
from station.views.figure import Axes, LinearSegmentedColormap, Picture, figure, literal, points, zero_lines
from station.views.palette import LIGHT, Look

NOISE = 2.0
SURE = 3.0
COARSE = 5000.0
TOO_MANY_DOTS = 60


def residual(axis: Axes, fit: Fit, channel: str, look: Look) -> None:
    """Draw what a model leaves of one channel over the band of its noise."""
    window = fit.windows[0]
    left = np.where(window.used[channel], fit.left(channel), np.nan)
    fine, name = scale(channel, window.unit, fine=True)
    if float(np.nanmax(np.abs(left))) * fine > COARSE:
        fine, name = scale(channel, window.unit)
    noise = NOISE * fit.noise(channel) * fine
    axis.axhspan(-noise, noise, color=look.noise, lw=0)
    for level in (-noise, noise):
        axis.axhline(level, color=look.faint, lw=0.5, ls=":")
    axis.plot(window.clock, left * fine, color=look.second, lw=0.7)
    axis.set_ylabel(literal(f"residual [{name}]"))


def front(fits: Sequence[tuple[str, Fit]], look: Look = LIGHT) -> Picture:
    """Draw a channel as measured and by the last of some models, and under it the residual of each, under its name."""
    last = fits[-1][1]
    window = last.windows[0]
    channel = window.channels[0]
    ratios = [1.6] + [1.0] * len(fits)
    drawn, axes = figure(look, 1.7 + 0.95 * len(fits), 1 + len(fits), sharex=True, height_ratios=ratios)
    factor, name = scale(channel, window.unit)
    measured = np.where(window.used[channel], window.readings[channel], np.nan) * factor
    model, top = last.predicted[0][channel] * factor, axes[0]
    top.plot(window.clock, measured, label="measured", color=look.broad, lw=2.4, solid_capstyle="round")
    top.plot(window.clock, model, label="model", color=look.model, lw=0.8)
    top.set_ylabel(literal(f"{channel}\n[{name}]"))
    top.legend(loc="upper right", ncols=2)
    top.margins(y=0.16)
    for axis, (words, fit) in zip(axes[1:], fits, strict=True):
        residual(axis, fit, channel, look)
        axis.set_title(literal(words), fontsize=8)
    axes[-1].set(xlabel="time since the release [s]", xlim=(window.clock[0], window.clock[-1]))
    return drawn


def phase_plane(found: Comparison, look: Look = LIGHT) -> Picture:
    """Draw the force that the model lacks over the phase plane, its sign written in each bin that stands out, and cuts."""
    plane, units = found.phase_plane, DiscrepancyText(found.unit, found.mass)
    factor, length = scale("displacement", found.unit)
    drawn, (wide, at_reversal, at_middle) = figure(look, 4.6, "aa;bc")
    force = plane.force * units.force_scale
    reach = float(np.nanmax(np.abs(force))) if np.isfinite(force).any() else 1.0
    colours = LinearSegmentedColormap.from_list("force", look.force)
    mesh = wide.pcolormesh(
        plane.displacement_edges * factor, plane.velocity_edges, np.ma.masked_invalid(force),
        cmap=colours, vmin=-reach, vmax=reach, edgecolors=look.paper, linewidth=0.4,
    )  # fmt: skip
    for row, column in plane.bins:
        if abs((plane.force / plane.std)[row, column]) > SURE:
            strong = abs(force[row, column]) > 0.7 * reach
            wide.text(
                plane.displacement[column] * factor, plane.velocity[row],
                "+" if force[row, column] > 0 else "−", ha="center", va="center", fontsize=9,
                color=look.paper if strong else look.ink,
            )  # fmt: skip
    wide.set(xlabel=literal(f"displacement [{length}]"), ylabel=literal(f"velocity [{found.unit}/s]"))
    wide.set_title("measured less model force")
    wide.grid(visible=False)
    bar = drawn.colorbar(mesh, ax=wide, pad=0.02)
    bar.set_label(literal(f"force [{units.force_unit}]"))
    bar.outline.set_visible(False)
    row, column = (count // 2 for count in plane.force.shape)
    for axis, position, cut, form, colour, label in (
        (at_reversal, plane.displacement * factor, row, "^-", look.second, "moving to the positive side"),
        (at_reversal, plane.displacement * factor, row - 1, "v--", look.model, "moving to the negative side"),
        (at_middle, plane.velocity, (slice(None), column), "o-", look.second, ""),
    ):
        std = plane.std[cut] * units.force_scale
        points(axis, position, plane.force[cut] * units.force_scale, std, form, colour, label)
        zero_lines(axis, look)
    at_reversal.set(xlabel=literal(f"displacement [{length}]"), title="at velocity 0: stiffness")
    drawn.legend(*at_reversal.get_legend_handles_labels(), loc="outside lower center", ncols=2)
    at_middle.set(xlabel=literal(f"velocity [{found.unit}/s]"), title="at displacement 0: damping")
    at_reversal.set_ylabel(literal(f"measured less\nmodel [{units.force_unit}]"))
    return drawn


def cycles(found: Comparison, look: Look = LIGHT) -> Picture:
    """Draw the errors of frequency and energy and the misfit of the free run, cycle by cycle."""
    done, units = found.cycles, DiscrepancyText(found.unit, found.mass)
    drawn, axes = figure(look, 2.2, 1, 3)
    factor, energy = energy_scale(units)
    rows = (
        (done.frequency_error, done.frequency_error_std, "frequency error [%]"),
        (done.energy_error * factor, done.energy_error_std * factor, f"energy error a cycle [{energy}]"),
        (found.free_run_misfit, None, "free run: rms misfit / noise"),
    )
    for axis, (values, std, label) in zip(axes, rows, strict=True):
        form = "o-" if len(values) < TOO_MANY_DOTS else "-"
        points(axis, done.time, values, std, form, look.model)
        axis.axhline(0 if std is not None else 1, color=look.faint, lw=0.8, ls="--")
        axis.set(xlabel="time since the release [s]", ylabel=literal(label))
    axes[-1].set_ylim(0, 1.1 * max(1.0, float(np.nanmax(found.free_run_misfit, initial=1.0))))
    return drawn
