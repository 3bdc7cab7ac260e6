"""The record, the alignment and both identifications in figures for paper."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from daq.manifest import FlagEntry
from daq.recording import Recording
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult
from station.report.drawing import INK, MODEL, OTHER, both, curve, embedded, joined, paper
from station.story.identification import Identification
from station.text.numbers import scale, scale_as_recorded
from station.views import plots
from station.views.alignment import about_zero, draw_about_zero, overlay
from station.views.plots import MOST_DOTS, PAPER, literal
from station.views.restoring_force import mesh

if TYPE_CHECKING:
    pass

SINCE = "time since the release [s]"
MOST_CHANNELS = 8
MOST_SHADED = 200
LONGEST = 24
COARSE = 3


def record(recording: Recording, release: float | None, flags: Sequence[FlagEntry] = ()) -> str:
    """Draw the channels as recorded, lost samples as holes, flagged ones shaded, the `release` (s) as a line."""
    channels = recording.channels[:MOST_CHANNELS]
    drawn, axes = paper(0.4 + 1.35 * len(channels), len(channels), sharex=True)
    begin = release or 0.0
    time = np.arange(recording.samples.shape[1]) / recording.rate - begin
    for axis, channel, samples in zip(axes, channels, recording.samples, strict=False):
        factor, label = scale_as_recorded(channel.quantity, channel.unit)
        curve(axis, time, np.where(recording.valid, samples, np.nan) * factor, color=INK, lw=0.7)
        name = channel.name if channel.quantity == "other" else channel.quantity
        axis.set_ylabel(literal(f"{name[:LONGEST]} [{label}]"))
        for run in [run for run in flags if run.channel == channel.name][:MOST_SHADED]:
            first, stop = run.first / recording.rate, (run.first + run.count) / recording.rate
            axis.axvspan(first - begin, stop - begin, color=OTHER, alpha=0.25, lw=0.5)
        if release is not None:
            axis.axvline(0.0, color=OTHER, lw=1.0, ls="--")
    name = "time from the first sample [s]" if release is None else SINCE
    axes[-1].set(xlabel=name, xlim=(time[0], time[-1] + 1.0 / recording.rate))
    return embedded(drawn)


def alignment(result: Identification) -> str | None:
    """Draw both channels as accelerations about a zero, before and after; None where there are not both."""
    seen = overlay(result)
    if seen is None or result.alignment is None or about_zero(result, seen) is None:
        return None
    drawn, axes = paper(2.1, 1, 2, sharey=True)
    draw_about_zero(axes, result, seen, PAPER)
    axes[0].legend(loc="upper left")
    return embedded(drawn)


def envelope(found: WaveletResult, length: str, release: float) -> str:
    """Draw envelope with fit, instantaneous frequency and backbone: the paper's figure 4 and what it rests on."""
    time = found.time - release
    factor, name = scale("displacement", length)
    drawn, axes = paper(3.9, 2, 2, width_ratios=[2.2, 1])
    top, _, below, _ = axes
    backbone = joined(drawn, axes[1::2])
    curve(top, time, found.envelope * factor, color="#b5b5b5", lw=2.6, label="ridge of the transform")
    curve(top, time, found.envelope_fit * factor, color=MODEL, lw=1.0, label="fit")
    top.set(xlabel=SINCE, ylabel=literal(f"envelope [{name}]"))
    top.set_ylim(bottom=0)
    top.legend(loc="upper right")
    frequency = np.where(found.trusted, found.frequency, np.nan)
    curve(below, time, frequency, color=INK, lw=0.9)
    middle = float(np.nanmedian(frequency)) if np.isfinite(frequency).any() else 1.0
    spread = np.abs(frequency - middle)
    half = max(1.5 * float(np.nanpercentile(spread, 98)) if np.isfinite(spread).any() else 0.0, 0.01 * middle)
    below.set(xlabel=SINCE, ylabel="instantaneous\nfrequency [Hz]", ylim=(middle - half, middle + half))
    below.set_xlim(top.get_xlim())
    plots.backbone(backbone, found, factor, name, half, PAPER, MODEL)
    backbone.set_title("backbone")
    backbone.legend(loc="upper left")
    return embedded(drawn)


def orders(result: Identification) -> str:
    """Draw the error against the order of damping by both methods and the significance of the terms: figure 3."""
    methods = [("wavelet", result.wavelet), ("restoring force", result.restoring_force)]
    there = [(name, found) for name, found in methods if found is not None]
    force = result.restoring_force
    columns = len(there) + (force is not None)
    drawn, axes = paper(2.2, 1, columns, width=WIDE[columns])
    for axis, (name, found) in zip(axes, there, strict=False):
        plots.orders(axis, found.mse_percent_by_order, found.order, PAPER, INK)
        axis.set_title(f"{name}: order {found.order}")
    if force is not None:
        plots.significance(axes[-1], force.significance_percent, PAPER)
    return embedded(drawn)


WIDE = {1: 3.0, 2: 5.0, 3: 6.9}


def reconstruction(result: Identification) -> str:
    """Draw the decay and the restoring force, measured and reconstructed, and the residual: figures 5 and 6."""
    wavelet, force, length = result.wavelet, result.restoring_force, result.decay.unit
    begin = result.release.time_s
    rows = 2 * ((wavelet is not None) + (force is not None))
    drawn, axes = paper(1.25 * rows, rows, height_ratios=[1.5, 1.0] * (rows // 2), sharex=True)
    row = 0
    if wavelet is not None:
        factor, name = scale(wavelet.channel, length)
        fine, fine_name = scale(wavelet.channel, length, fine=True)
        measured, model = result.rebuilt_decay(wavelet)
        both(
            axes[0], wavelet.time - begin, measured * factor, model * factor, ("measured", "rebuilt, wavelet")
        )
        axes[0].set_ylabel(literal(f"{wavelet.channel}\n[{name}]"))
        curve(axes[1], wavelet.time - begin, (measured - model) * fine, color=OTHER, lw=0.7)
        axes[1].set_ylabel(literal(f"residual [{fine_name}]"))
        row = 2
    if force is not None:
        label = f"{length}/s^2"
        both(
            axes[row],
            force.time - begin,
            force.force,
            force.force_fit,
            ("measured", "fitted, restoring force"),
        )
        axes[row].set_ylabel(literal(f"force per unit\nmass [{label}]"))
        curve(axes[row + 1], force.time - begin, force.force - force.force_fit, color=OTHER, lw=0.7)
        axes[row + 1].set_ylabel(literal(f"residual [{label}]"))
    for place in range(0, rows, 2):
        axes[place].legend(loc="upper right", ncols=2)
        axes[place].margins(y=0.16)
    axes[-1].set_xlabel(SINCE)
    return embedded(drawn)


def surface(found: RestoringForceResult, length: str) -> str:
    """Draw the restoring force surface over displacement and velocity with the measured points on it."""
    from matplotlib.tri import Triangulation

    factor, name = scale("displacement", length)
    drawn, (flat,) = paper(3.3, subplot_kw={"projection": "3d"}, width=5.2)
    axis: Any = flat  # three-dimensional, which the types of a plain pair of axes do not know
    coarse = replace(
        found,
        grid_displacement=found.grid_displacement[::COARSE],
        grid_velocity=found.grid_velocity[::COARSE],
        surface=found.surface[::COARSE, ::COARSE],
    )
    vertices, triangles = mesh(coarse)
    net = Triangulation(vertices[:, 0] * factor, vertices[:, 1], triangles)
    axis.plot_trisurf(
        net, vertices[:, 2], color="#e4e4e4", edgecolor="#9a9a9a", lw=0.2, alpha=0.75, rasterized=True
    )
    every = max(1, len(found.force) // MOST_DOTS)
    points = (found.displacement * factor, found.velocity, found.force)
    axis.plot(*(values[::every] for values in points), ".", color=INK, ms=1.6)
    axis.set_xlabel(literal(f"displacement [{name}]"))
    axis.set_ylabel(literal(f"velocity [{length}/s]"))
    axis.set_zlabel(literal(f"force per unit mass [{length}/s^2]"))
    axis.locator_params(nbins=5)
    axis.view_init(22, -125)
    axis.set_box_aspect((1.3, 1.3, 0.9), zoom=0.9)
    return embedded(drawn)


def sections(found: RestoringForceResult, length: str) -> str:
    """Draw the cuts through the surface where velocity or displacement is zero."""
    factor, name = scale("displacement", length)
    drawn, axes = paper(2.3, 1, 2)
    first = (found.section_zero_velocity, factor, f"displacement [{name}]", "at velocity 0: the springs")
    second = (
        found.section_zero_displacement, 1.0, f"velocity [{length}/s]", "at displacement 0: the damping",
    )  # fmt: skip
    for axis, (cut, factor, label, title) in zip(axes, (first, second), strict=True):
        plots.force_section(axis, cut, factor, PAPER)
        axis.set(xlabel=literal(label), title=title)
    axes[0].set_ylabel(literal(f"force per unit mass [{length}/s^2]"))
    axes[0].legend(loc="upper left")
    return embedded(drawn)
