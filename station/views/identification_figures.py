"""The record and both identifications in figures."""

from collections.abc import Mapping, Sequence

import numpy as np

from daq.recording import Recording
from daq.sensor_faults import FlaggedRun
from identify.formatting import three_figures
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult
from station.story.engineering_values import Weighing
from station.story.pipeline import Identification
from station.text.numbers import scale, scale_as_recorded
from station.views.figure import Axes, Picture, figure, literal, zero_lines
from station.views.palette import LIGHT, Look

SINCE = "time since the release [s]"
MOST_CHANNELS = 8
MOST_SHADED = 200
LONGEST = 24
LEAST_SHARE = 1e-6
MOST_DOTS = 250
WIDE = {1: 3.0, 2: 5.0, 3: 6.9}


def record(
    recording: Recording, release: float | None = None, flags: Sequence[FlaggedRun] = (), look: Look = LIGHT
) -> Picture:
    """Draw the channels as recorded, lost samples as holes, flagged ones shaded, the `release` (s) as a line."""
    channels = recording.channels[:MOST_CHANNELS]
    drawn, axes = figure(look, 0.4 + 1.35 * len(channels), len(channels), sharex=True)
    begin = release or 0.0
    time = np.arange(recording.samples.shape[1]) / recording.rate - begin
    for axis, channel, samples in zip(axes, channels, recording.samples, strict=False):
        factor, label = scale_as_recorded(channel.quantity, channel.unit)
        axis.plot(time, np.where(recording.valid, samples, np.nan) * factor, color=look.ink, lw=0.7)
        name = channel.name if channel.quantity == "other" else channel.quantity
        axis.set_ylabel(literal(f"{name[:LONGEST]} [{label}]"))
        for run in [run for run in flags if run.channel == channel.name][:MOST_SHADED]:
            first, stop = run.first / recording.rate, (run.first + run.count) / recording.rate
            axis.axvspan(first - begin, stop - begin, color=look.second, alpha=0.25, lw=0.5)
        if release is not None:
            axis.axvline(0.0, color=look.second, lw=1.0, ls="--")
    name = "time from the first sample [s]" if release is None else SINCE
    axes[-1].set(xlabel=name, xlim=(time[0], time[-1] + 1.0 / recording.rate))
    return drawn


def envelope(found: WaveletResult, length: str, release: float) -> Picture:
    """Draw envelope with fit, instantaneous frequency and backbone: the paper's figure 4 and what it rests on."""
    time = found.time - release
    factor, name = scale("displacement", length)
    drawn, (top, backbone, below) = figure(LIGHT, 3.9, "ab;cb", width_ratios=[2.2, 1])
    top.plot(time, found.envelope * factor, color=LIGHT.broad, lw=2.6, label="ridge of the transform")
    top.plot(time, found.envelope_fit * factor, color=LIGHT.model, lw=1.0, label="fit")
    top.set(xlabel=SINCE, ylabel=literal(f"envelope [{name}]"))
    top.set_ylim(bottom=0)
    top.legend(loc="upper right")
    frequency = np.where(found.trusted, found.frequency, np.nan)
    below.plot(time, frequency, color=LIGHT.ink, lw=0.9)
    middle, half = frequency_reach(found)
    below.set(xlabel=SINCE, ylabel="instantaneous\nfrequency [Hz]", ylim=(middle - half, middle + half))
    below.set_xlim(top.get_xlim())
    _backbone(backbone, found, length, LIGHT)
    backbone.set_title("backbone")
    return drawn


def frequency_reach(found: WaveletResult) -> tuple[float, float]:
    """Choose the range of the instantaneous frequency's axis, Hz: the middle of the trusted part, and half the width."""
    trusted = found.frequency[found.trusted]
    middle = float(np.median(trusted if len(trusted) else found.frequency))
    spread = float(np.percentile(np.abs(trusted - middle), 98)) if len(trusted) else 0.0
    return middle, max(1.5 * spread, 0.01 * middle)


def _backbone(axis: Axes, found: WaveletResult, length: str, look: Look) -> None:
    """Draw amplitude over frequency on the ridge, and of the fit."""
    (factor, name), (middle, half) = scale("displacement", length), frequency_reach(found)
    shown = np.flatnonzero(found.trusted)
    shown = shown[:: max(1, len(shown) // MOST_DOTS)]
    amplitude = found.envelope[shown] * factor
    axis.plot(found.frequency[shown], amplitude, "o", color=look.measured, ms=2.5, label="ridge")
    axis.plot(found.frequency_fit[shown], amplitude, color=look.model, lw=1.4, label="averaged model")
    limits = (middle - half, middle + half)
    axis.set(xlim=limits, xlabel="frequency [Hz]", ylabel=literal(f"amplitude [{name}]"))
    axis.set_ylim(0, 1.25 * float(np.max(amplitude, initial=1e-12)))  # with room for the legend
    axis.locator_params(axis="x", nbins=4)
    axis.legend(loc="upper left")


def backbone(found: WaveletResult, length: str, look: Look) -> Picture:
    """Draw the backbone alone."""
    drawn, (axis,) = figure(look, 3.6, width=4.2)
    _backbone(axis, found, length, look)
    return drawn


def scalogram(found: WaveletResult, look: Look) -> Picture:
    """Draw the modulus of the transform over time and frequency, with its ridge."""
    drawn, (axis,) = figure(look, 3.6, width=7.2)
    modulus = found.scalogram / max(float(np.max(found.scalogram)), np.finfo(float).tiny)
    shown = axis.pcolormesh(
        found.scalogram_time, found.scalogram_frequency, 20 * np.log10(np.maximum(modulus, 1e-4)),
        cmap="magma", vmin=-60, vmax=0, shading="nearest", rasterized=True,
    )  # fmt: skip
    low, high = found.scalogram_frequency.min(), found.scalogram_frequency.max()
    axis.plot(found.time, np.clip(found.frequency, low, high), ":", color="white")
    ridge = np.where(found.trusted, found.frequency, np.nan)
    axis.plot(found.time, ridge, color="white", lw=1.8, label="ridge (dotted: not trusted)")
    axis.set(xlabel="time [s]", ylabel="frequency [Hz]", ylim=(low, high))
    axis.grid(visible=False)
    axis.legend(loc="upper right", labelcolor="white")
    drawn.colorbar(shown, ax=axis, pad=0.01, label="modulus [dB of its maximum]").outline.set_visible(False)
    return drawn


def orders(result: Identification, look: Look = LIGHT) -> Picture:
    """Draw the error against the order of damping by both methods and the significance of the terms: figure 3."""
    methods = [("wavelet", result.wavelet), ("restoring force", result.restoring_force)]
    there = [(name, found) for name, found in methods if found is not None]
    force = result.restoring_force
    columns = len(there) + (force is not None)
    drawn, axes = figure(look, 2.2, 1, columns, width=WIDE[columns])
    for axis, (name, found) in zip(axes, there, strict=False):
        errors = found.mse_percent_by_order
        axis.semilogy(range(len(errors)), errors, "o-", color=look.ink, ms=5)
        axis.semilogy([found.order], [errors[found.order]], "o", ms=13, mfc="none", mec=look.ink, mew=1.5)
        axis.set(xlabel="order of damping", ylabel="MSE [%]", xticks=range(len(errors)))
        axis.margins(x=0.15, y=0.2)
        axis.set_title(f"{name}: order {found.order}")
    if force is not None:
        _significance(axes[-1], force.significance_percent, look)
    return drawn


def _significance(axis: Axes, percent: Mapping[str, float], look: Look) -> None:
    """Draw the share of the variance of each term of the restoring force, eq. (19), on a logarithmic axis."""
    terms = sorted(percent.items(), key=lambda item: -item[1])
    values = [max(value, LEAST_SHARE) for _, value in terms]
    axis.barh(range(len(terms)), values, color=look.broad, edgecolor=look.ink, lw=0.5, height=0.6, log=True)
    for row, (_, value) in enumerate(terms):
        label = f" {three_figures(value)} %" if value >= 0.01 else f" {value:.1g} %"
        axis.annotate(label, (values[row], row), va="center", fontsize=8, color=look.ink)
    axis.set_yticks(range(len(terms)), [literal(name) for name, _ in terms])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlim(min(values, default=1.0) / 3, 2e4)
    axis.set(xlabel="share of the variance [%]", title="significance")


def sections(found: RestoringForceResult, weighing: Weighing, look: Look = LIGHT) -> Picture:
    """Draw the cuts through the surface where velocity or displacement is zero."""
    length, (size, unit) = weighing.unit, weighing.force_scale
    factor, name = scale("displacement", length)
    drawn, axes = figure(look, 2.3, 1, 2)
    first = (found.section_zero_velocity, factor, f"displacement [{name}]", "at velocity 0: the springs")
    second = (
        found.section_zero_displacement, 1.0, f"velocity [{length}/s]", "at displacement 0: the damping",
    )  # fmt: skip
    for axis, (cut, factor, label, title) in zip(axes, (first, second), strict=True):
        x, every = cut.position * factor, max(1, len(cut.position) // MOST_DOTS)
        axis.plot(x[::every], cut.force[::every] * size, "o", color=look.measured, ms=2.5, label="measured")
        axis.plot(x, cut.fit * size, color=look.model, lw=1.4, label="fit")
        zero_lines(axis, look)
        axis.set(xlabel=literal(label), title=title)
    axes[0].set_ylabel(literal(f"{weighing.worded()} [{unit}]"))
    axes[0].legend(loc="upper left")
    return drawn
