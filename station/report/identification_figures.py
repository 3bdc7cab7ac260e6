"""The record, the alignment and both identifications in figures for paper."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from daq.recording import Recording
from identify.restoring_force.restoring_force import RestoringForceResult, Section
from identify.wavelet.wavelet import WaveletResult
from station.report.drawing import (
    GREY,
    INK,
    MODEL,
    OTHER,
    both,
    curve,
    embedded,
    joined,
    literal,
    paper,
    zero_lines,
)
from station.story.identification import Identification
from station.text.numbers import scale, scale_as_recorded, typeset, typeset_figures, typeset_unit
from station.views.alignment import overlay
from station.views.log import Array
from station.views.restoring_force import mesh

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_CHANNELS = 8
LONGEST = 24
NEAR = 0.06
MOST_DOTS = 500
COARSE = 3


def record(recording: Recording, release: float | None) -> str:
    """Draw the channels as recorded, lost samples as holes, the `release` (s) as a line: the paper's figure 2."""
    channels = recording.channels[:MOST_CHANNELS]
    drawn, axes = paper(0.4 + 1.35 * len(channels), len(channels), sharex=True)
    time = np.arange(recording.samples.shape[1]) / recording.rate
    for axis, channel, samples in zip(axes, channels, recording.samples, strict=False):
        factor, label = scale_as_recorded(channel.quantity, channel.unit)
        curve(axis, time, np.where(recording.valid, samples, np.nan) * factor, color=INK, lw=0.7)
        name = channel.name if channel.quantity == "other" else channel.quantity
        axis.set_ylabel(literal(f"{name[:LONGEST]} [{typeset_unit(label)}]"))
        if release is not None:
            axis.axvline(release, color=OTHER, lw=1.0, ls="--")
    axes[-1].set(xlabel="time from the first sample [s]", xlim=(0.0, time[-1] + 1.0 / recording.rate))
    return embedded(drawn)


def alignment(result: Identification) -> str | None:
    """Draw both channels as accelerations about a zero, before and after; None where there are not both."""
    seen, found = overlay(result), result.alignment
    method = result.restoring_force or result.wavelet
    if seen is None or found is None or method is None or method.stiffness_per_mass.value <= 0:
        return None
    period = 2 * np.pi / np.sqrt(method.stiffness_per_mass.value)
    later = np.flatnonzero(seen.time > result.release.settle / result.decay.rate + period)
    crossings = np.flatnonzero(np.diff(np.sign(seen.acceleration[later])) > 0)
    if not len(crossings):
        return None
    middle = seen.time[later[crossings[0]]]
    near = np.abs(seen.time - middle) < max(NEAR * period, 4 / result.decay.rate)
    drawn, axes = paper(2.1, 1, 2, sharey=True)
    titles = ("as recorded", "lag corrected")
    for axis, second, title in zip(axes, (seen.before, seen.after), titles, strict=True):
        ms = (seen.time[near] - middle) * 1e3
        axis.plot(ms, seen.acceleration[near], "o-", color=INK, ms=4, mfc="white", label="acceleration")
        axis.plot(
            ms, found.gain.value * second[near], "x--", color=MODEL, ms=4.5,
            label="displacement, differentiated twice",
        )  # fmt: skip
        axis.set(xlabel="time about a zero of the acceleration [ms]", title=title)
    axes[0].set_ylabel(literal(f"acceleration [{typeset_unit(f'{result.decay.unit}/s^2')}]"))
    axes[0].legend(loc="upper left")
    return embedded(drawn)


def envelope(found: WaveletResult, length: str) -> str:
    """Draw envelope with fit, instantaneous frequency and backbone: the paper's figure 4 and what it rests on."""
    factor, name = scale("displacement", length)
    drawn, axes = paper(3.9, 2, 2, width_ratios=[2.2, 1])
    top, _, below, _ = axes
    backbone = joined(drawn, axes[1::2])
    curve(top, found.time, found.envelope * factor, color="#b5b5b5", lw=2.6, label="ridge of the transform")
    curve(top, found.time, found.envelope_fit * factor, color=MODEL, lw=1.0, label="fit, eq. (5)")
    top.set(xlabel="time [s]", ylabel=literal(f"envelope [{name}]"))
    top.set_ylim(bottom=0)
    top.legend(loc="upper right")
    frequency = np.where(found.trusted, found.frequency, np.nan)
    curve(below, found.time, frequency, color=INK, lw=0.9)
    middle = float(np.nanmedian(frequency)) if np.isfinite(frequency).any() else 1.0
    spread = np.abs(frequency - middle)
    half = max(1.5 * float(np.nanpercentile(spread, 98)) if np.isfinite(spread).any() else 0.0, 0.01 * middle)
    below.set(xlabel="time [s]", ylabel="instantaneous\nfrequency [Hz]", ylim=(middle - half, middle + half))
    below.set_xlim(top.get_xlim())
    amplitude = found.backbone_amplitude * factor
    every = max(1, len(amplitude) // MOST_DOTS)
    backbone.plot(
        found.backbone_frequency[::every], amplitude[::every], "o", color=GREY, ms=2.5, label="ridge"
    )
    backbone.plot(found.backbone_fit[::every], amplitude[::every], color=MODEL, lw=1.0, label="model")
    backbone.set(xlabel="frequency [Hz]", ylabel=literal(f"amplitude [{name}]"), title="backbone")
    backbone.set_xlim(middle - half, middle + half)
    backbone.set_ylim(bottom=0)
    backbone.legend(loc="upper left")
    backbone.locator_params(axis="x", nbins=3)
    return embedded(drawn)


def orders(result: Identification) -> str:
    """Draw the error against the order of damping by both methods and the significance of the terms: figure 3."""
    methods = [("wavelet", result.wavelet), ("restoring force", result.restoring_force)]
    there = [(name, found) for name, found in methods if found is not None]
    force = result.restoring_force
    columns = len(there) + (force is not None)
    drawn, axes = paper(2.2, 1, columns, width=WIDE[columns])
    for axis, (name, found) in zip(axes, there, strict=False):
        errors = found.mse_percent_by_order
        axis.semilogy(range(len(errors)), errors, "o-", color=INK, ms=4)
        axis.semilogy([found.order], [errors[found.order]], "o", ms=11, mfc="none", mec=OTHER, mew=1.4)
        axis.set(
            xlabel="order of damping", ylabel="MSE [%]", xticks=range(len(errors)),
            title=f"{name}: order {found.order}",
        )  # fmt: skip
        axis.margins(x=0.15, y=0.2)
    if force is not None:
        _significance(axes[-1], force)
    return embedded(drawn)


WIDE = {1: 3.0, 2: 5.0, 3: 6.9}


def _significance(axis: "Axes", found: RestoringForceResult) -> None:
    terms = sorted(found.significance_percent.items(), key=lambda item: -item[1])
    values = [max(value, 1e-6) for _, value in terms]
    axis.barh(range(len(terms)), values, color="#b5b5b5", edgecolor=INK, lw=0.6, height=0.6, log=True)
    for row, value in enumerate(values):
        axis.annotate(f" {typeset_figures(value)} %", (value, row), va="center", fontsize=8)
    axis.set_yticks(range(len(terms)), [literal(typeset(name)) for name, _ in terms])
    axis.invert_yaxis()
    axis.set_xlim(min(values, default=1.0) / 3, 2e4)
    axis.set(xlabel="share of the variance [%]", title="significance, eq. (19)")


def reconstruction(result: Identification) -> str:
    """Draw the decay and the restoring force, measured and reconstructed, and what is left: figures 5 and 6."""
    wavelet, force, length = result.wavelet, result.restoring_force, result.decay.unit
    rows = 2 * ((wavelet is not None) + (force is not None))
    drawn, axes = paper(1.25 * rows, rows, height_ratios=[1.5, 1.0] * (rows // 2), sharex=True)
    row = 0
    if wavelet is not None:
        factor, name = scale(wavelet.channel, length)
        fine, fine_name = scale(wavelet.channel, length, fine=True)
        measured = getattr(result.aligned, wavelet.channel)
        index = np.clip(np.round(wavelet.time * result.decay.rate).astype(int), 0, len(measured) - 1)
        offset = float(np.median(measured[index] - wavelet.reconstruction))
        model = wavelet.reconstruction + offset
        both(
            axes[0], wavelet.time, measured[index] * factor, model * factor, ("measured", "rebuilt, wavelet")
        )
        axes[0].set_ylabel(literal(f"{wavelet.channel}\n[{typeset_unit(name)}]"))
        curve(axes[1], wavelet.time, (measured[index] - model) * fine, color=OTHER, lw=0.7)
        axes[1].set_ylabel(literal(f"left [{typeset_unit(fine_name)}]"))
        row = 2
    if force is not None:
        label = typeset_unit(f"{length}/s^2")
        both(axes[row], force.time, force.force, force.force_fit, ("measured", "fitted, restoring force"))
        axes[row].set_ylabel(literal(f"force per unit\nmass [{label}]"))
        curve(axes[row + 1], force.time, force.force - force.force_fit, color=OTHER, lw=0.7)
        axes[row + 1].set_ylabel(literal(f"left [{label}]"))
    for place in range(0, rows, 2):
        axes[place].legend(loc="upper right", ncols=2)
        axes[place].margins(y=0.16)
    axes[-1].set_xlabel("time from the first sample [s]")
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
    axis.plot_trisurf(net, vertices[:, 2], color="#e4e4e4", edgecolor="#9a9a9a", lw=0.2, alpha=0.75)
    every = max(1, len(found.force) // MOST_DOTS)
    points = (found.displacement * factor, found.velocity, found.force)
    axis.plot(*(values[::every] for values in points), ".", color=INK, ms=1.6)
    axis.set_xlabel(literal(f"displacement [{name}]"))
    axis.set_ylabel(literal(f"velocity [{typeset_unit(f'{length}/s')}]"))
    axis.set_zlabel(literal(f"force per unit mass [{typeset_unit(f'{length}/s^2')}]"))
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
        found.section_zero_displacement, 1.0, f"velocity [{typeset_unit(f'{length}/s')}]", "at displacement 0: the damping",
    )  # fmt: skip
    for axis, (cut, factor, label, title) in zip(axes, (first, second), strict=True):
        _cut(axis, cut, factor)
        axis.set(xlabel=literal(label), title=title)
    axes[0].set_ylabel(literal(f"force per unit mass [{typeset_unit(f'{length}/s^2')}]"))
    axes[0].legend(loc="upper left")
    return embedded(drawn)


def _cut(axis: "Axes", cut: Section, factor: float) -> None:
    x: Array = cut.position * factor
    axis.errorbar(
        x, cut.force, yerr=2 * cut.std, fmt="o", ms=3, mfc="white", lw=0.8, capsize=2, color=INK,
        label="measured, 2 std. errors",
    )  # fmt: skip
    axis.plot(x, cut.fit, color=MODEL, lw=1.2, label="fit")
    zero_lines(axis)
