"""Where a model fails, in figures for paper: measurement and model, the phase plane, cycle by cycle."""

from typing import TYPE_CHECKING

import numpy as np

from identify.comparison.discrepancy_text import DiscrepancyText
from station.report.drawing import BAND, GREY, INK, OTHER, both, curve, embedded, joined, paper
from station.story.compared import Compared
from station.text.numbers import energy_scale, scale
from station.views import plots
from station.views.plots import PAPER, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NOISE = 2.0
SURE = 3.0
COARSE = 5000.0


def measured_and_model(axis: "Axes", compared: Compared, channel: str) -> None:
    """Draw one channel as it was measured, and the model run freely."""
    fit = compared.baseline.fit
    window = fit.windows[0]
    factor, name = scale(channel, window.unit)
    measured = np.where(window.used[channel], window.readings[channel], np.nan)
    both(axis, window.clock, measured * factor, fit.predicted[0][channel] * factor, ("measured", "model"))
    axis.set_ylabel(literal(f"{channel}\n[{name}]"))
    axis.legend(loc="upper right", ncols=2)
    axis.margins(y=0.16)


def left_over(axis: "Axes", compared: Compared, channel: str) -> None:
    """Draw what a model leaves of one channel over the band of its noise."""
    fit = compared.baseline.fit
    window = fit.windows[0]
    left = np.where(window.used[channel], fit.residual(channel), np.nan)
    fine, name = scale(channel, window.unit, fine=True)
    if float(np.nanmax(np.abs(left))) * fine > COARSE:
        fine, name = scale(channel, window.unit)
    noise = NOISE * window.sigma[channel] * fine
    axis.axhspan(-noise, noise, color=BAND, lw=0)
    for level in (-noise, noise):
        axis.axhline(level, color=GREY, lw=0.5, ls=":")
    curve(axis, window.clock, left * fine, color=OTHER, lw=0.7)
    axis.set_ylabel(literal(f"residual [{name}]"))


def front(first: Compared | None, last: Compared) -> str:
    """Draw measurement and current model in one channel, and under them the residual before and after."""
    window = last.baseline.fit.windows[0]
    channel = window.channels[0]
    shown = [one for one in (first, last) if one is not None]
    drawn, axes = paper(
        1.7 + 0.95 * len(shown), 1 + len(shown), sharex=True, height_ratios=[1.6] + [1.0] * len(shown)
    )
    measured_and_model(axes[0], last, channel)
    for axis, compared in zip(axes[1:], shown, strict=True):
        left_over(axis, compared, channel)
        axis.set_title(compared.words, fontsize=8)
    axes[-1].set(xlabel="time since the release [s]", xlim=(window.clock[0], window.clock[-1]))
    return embedded(drawn)


def phase_plane(compared: Compared) -> str:
    """Draw the force that the model lacks over the phase plane, its sign written in each bin that stands out, and cuts."""
    found = compared.comparison
    plane, units = found.phase_plane, DiscrepancyText(found.unit, found.mass)
    factor, length = scale("displacement", found.unit)
    drawn, axes = paper(4.6, 2, 2)
    at_reversal, at_middle = axes[2:]
    wide = joined(drawn, axes[:2])
    force = plane.force * units.force_scale
    reach = float(np.nanmax(np.abs(force))) if np.isfinite(force).any() else 1.0
    mesh = wide.pcolormesh(
        plane.displacement_edges * factor, plane.velocity_edges, np.ma.masked_invalid(force),
        cmap="PuOr", vmin=-reach, vmax=reach, edgecolors="white", linewidth=0.4,
    )  # fmt: skip
    for row, column in plane.bins:
        if abs(plane.significance[row, column]) > SURE:
            dark = abs(force[row, column]) > 0.7 * reach
            wide.text(
                plane.displacement[column] * factor, plane.velocity[row],
                "+" if force[row, column] > 0 else "−", ha="center", va="center", fontsize=9,
                color="white" if dark else INK,
            )  # fmt: skip
    wide.set(xlabel=literal(f"displacement [{length}]"), ylabel=literal(f"velocity [{found.unit}/s]"))
    wide.set_title("measured less model force")
    wide.grid(visible=False)
    bar = drawn.colorbar(mesh, ax=wide, pad=0.02)
    bar.set_label(literal(f"force [{units.force_unit}]"))
    bar.outline.set_visible(False)
    down, up = plane.sections_at_reversal
    plots.missing_section(at_reversal, up, factor, units, PAPER, "^-", "moving to the positive side")
    plots.missing_section(at_reversal, down, factor, units, PAPER, "v--", "moving to the negative side")
    at_reversal.set(xlabel=literal(f"displacement [{length}]"), title="at velocity 0: stiffness")
    at_reversal.legend(loc="best")
    plots.missing_section(at_middle, plane.section_at_middle, 1.0, units, PAPER, "o-", "")
    at_middle.set(xlabel=literal(f"velocity [{found.unit}/s]"), title="at displacement 0: damping")
    at_reversal.set_ylabel(literal(f"measured less\nmodel [{units.force_unit}]"))
    return embedded(drawn)


def cycles(compared: Compared) -> str:
    """Draw the errors of frequency and energy and the misfit of the free run, cycle by cycle."""
    found = compared.comparison
    done, units = found.cycles, DiscrepancyText(found.unit, found.mass)
    drawn, axes = paper(2.2, 1, 3)
    factor, energy = energy_scale(units)
    rows = (
        (done.frequency_error, done.frequency_error_std, "frequency error [%]"),
        (done.energy_error * factor, done.energy_error_std * factor, f"energy error a cycle [{energy}]"),
        (found.free_run_misfit, None, "free run: rms misfit / noise"),
    )
    for axis, (values, std, label) in zip(axes, rows, strict=True):
        plots.cycle_by_cycle(axis, done.time, values, std, PAPER)
        axis.set(xlabel="time since the release [s]", ylabel=literal(label))
    axes[-1].set_ylim(bottom=0)
    return embedded(drawn)
