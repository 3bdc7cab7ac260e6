"""Plots that the viewer and the report share: the same curves, in light on dark for a screen or in ink for paper."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from identify.arrays import Array
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.phase_plane import ForceSection
from identify.diagnosis.force_map import ForceMap
from identify.restoring_force.restoring_force import Section
from identify.wavelet.wavelet import WaveletResult
from station.results.diagnosis_document import CurveDocument
from station.story.measured_curves import MeasuredCurve
from station.text.numbers import scale_as_recorded, three_figures, typeset
from station.views import palette

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LEAST = 0.7
LEAST_SHARE = 1e-6
MOST_DOTS = 250
TOO_MANY_DOTS = 60


@dataclass(frozen=True)
class Look:
    """Colours of what is drawn: text, lines of reference, a measurement, a model, a second curve, and the noise's band."""

    ink: str
    faint: str
    measured: str
    model: str
    second: str
    noise: str
    bar: str


SCREEN = Look(
    ink=palette.INK,
    faint=palette.FAINT,
    measured=palette.css(palette.MEASURED),
    model=palette.css(palette.FORCE),
    second=palette.css(palette.ACCELERATION),
    noise="#00966e44",
    bar=palette.css(palette.FORCE),
)

PAPER = Look(
    ink="#111111",
    faint="#8c8c8c",
    measured="#7d7d7d",
    model="#00447c",
    second="#111111",
    noise="#d4d4d4",
    bar="#c4c4c4",
)


def literal(text: str) -> str:
    """Return text that matplotlib draws as it stands, whatever signs a stranger's names hold."""
    return typeset(text).replace("$", r"\$")


def zero_lines(axis: "Axes", look: Look) -> None:
    """Draw the axes through zero."""
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.axvline(0, color=look.faint, lw=0.7)


def orders(axis: "Axes", errors: Sequence[float], chosen: int, look: Look, colour: str) -> None:
    """Draw the error against the order of damping, the paper's figure 3, with a circle about the order chosen."""
    axis.semilogy(range(len(errors)), errors, "o-", color=colour, ms=5)
    axis.semilogy([chosen], [errors[chosen]], "o", ms=13, mfc="none", mec=look.ink, mew=1.5)
    axis.set(xlabel="order of damping", ylabel="MSE [%]", xticks=range(len(errors)))
    axis.margins(x=0.15, y=0.2)


def significance(axis: "Axes", percent: Mapping[str, float], look: Look) -> None:
    """Draw the share of the variance of each term of the restoring force, eq. (19), on a logarithmic axis."""
    terms = sorted(percent.items(), key=lambda item: -item[1])
    values = [max(value, LEAST_SHARE) for _, value in terms]
    axis.barh(range(len(terms)), values, color=look.bar, edgecolor=look.ink, lw=0.5, height=0.6, log=True)
    for row, (_, value) in enumerate(terms):
        label = f" {three_figures(value)} %" if value >= 0.01 else f" {value:.1g} %"
        axis.annotate(label, (values[row], row), va="center", fontsize=8, color=look.ink)
    _rows(axis, [name for name, _ in terms])
    axis.set_xlim(min(values, default=1.0) / 3, 2e4)
    axis.set(xlabel="share of the variance [%]", title="significance, eq. (19)")


def backbone(
    axis: "Axes", found: WaveletResult, factor: float, unit: str, half: float, look: Look, colour: str
) -> None:
    """Draw amplitude (SI times `factor`, in `unit`) over frequency on the ridge, and of the fit; `half` the width in Hz."""
    every = max(1, len(found.backbone_frequency) // MOST_DOTS)
    amplitude = found.backbone_amplitude[::every] * factor
    axis.plot(found.backbone_frequency[::every], amplitude, "o", color=look.measured, ms=2.5, label="ridge")
    axis.plot(found.backbone_fit[::every], amplitude, color=colour, lw=1.4, label="averaged model")
    middle = float(np.median(found.backbone_frequency)) if len(found.backbone_frequency) else 1.0
    axis.set(
        xlim=(middle - half, middle + half), xlabel="frequency [Hz]", ylabel=literal(f"amplitude [{unit}]")
    )
    axis.set_ylim(bottom=0)
    axis.ticklabel_format(axis="x", useOffset=False)
    axis.locator_params(axis="x", nbins=4)


def force_section(axis: "Axes", cut: Section, factor: float, look: Look) -> None:
    """Draw a cut through the restoring force surface: measured with two standard errors, and the fit."""
    x = cut.position * factor
    _errorbar(axis, x, cut.force, 2 * cut.std, "o", look.measured, "measured, 2 std. errors")
    axis.plot(x, cut.fit, color=look.model, lw=1.4, label="fit")
    zero_lines(axis, look)


def missing_section(
    axis: "Axes", cut: ForceSection, factor: float, units: DiscrepancyText, look: Look, form: str, label: str
) -> None:
    """Draw a cut through the force that the model lacks, with two standard errors; `form` as matplotlib takes it."""
    colour = look.model if form.startswith("v") else look.second
    force, error = cut.force * units.force_scale, 2 * cut.std * units.force_scale
    _errorbar(axis, cut.position * factor, force, error, form, colour, label)
    zero_lines(axis, look)


def cycle_by_cycle(axis: "Axes", x: Array, values: Array, std: Array | None, look: Look) -> None:
    """Draw what is known of each cycle, with two standard errors where they are known."""
    form = "o-" if len(values) < TOO_MANY_DOTS else "-"
    _errorbar(axis, x, values, None if std is None else 2 * std, form, look.model, "")
    axis.axhline(0 if std is not None else 1, color=look.faint, lw=0.8, ls="--")


def _errorbar(
    axis: "Axes", x: Array, y: Array, error: Array | None, form: str, colour: str, label: str
) -> None:
    axis.errorbar(x, y, yerr=error, fmt=form, ms=3.5, lw=0.9, capsize=2, color=colour, label=label or None)


def residuals(
    axis: "Axes",
    rows: Sequence[tuple[str, float]],
    std: float,
    look: Look,
    colours: Sequence[str] = (),
    when: str = "",
) -> None:
    """Draw the residuals of reduced chi-squares as bars on a logarithmic axis, with the noise (1, band: 2 std. errors)."""
    values, std = np.sqrt([value for _, value in rows]), std / 2.0
    lengths = np.maximum(values, LEAST * 1.05) - LEAST
    axis.barh(
        range(len(rows)), lengths, left=LEAST, color=colours or look.bar, edgecolor=look.ink, lw=0.5,
        height=0.62,
    )  # fmt: skip
    for row, value in enumerate(values):
        place = (max(float(value), 1.0), row)
        axis.annotate(f" {three_figures(float(value))}", place, va="center", fontsize=8, color=look.ink)
    axis.axvspan(max(1 - 2 * std, LEAST), 1 + 2 * std, color=look.noise, lw=0, zorder=0)
    axis.axvline(1, color=look.ink, lw=1.0, ls="--")
    axis.set_xscale("log")
    axis.set_xlabel(f"rms of the residual{when}, times the noise (logarithmic; dashed: noise alone)")
    axis.set_xlim(LEAST, 2.5 * max(float(np.max(values, initial=0.0)), 2.0))
    _rows(axis, [name for name, _ in rows])


def _rows(axis: "Axes", names: Sequence[str]) -> None:
    axis.set_yticks(range(len(names)), [literal(name) for name in names])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)


def force_over_cycle(axis: "Axes", found: ForceMap, look: Look) -> None:
    """Draw the mean force over the phase of the cycle, of the large and of the small cycles."""
    degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.plot(degrees, found.large, color=look.second, lw=1.5, label="large cycles")
    axis.plot(degrees, found.small, color=look.model, lw=1.3, ls="--", label="small cycles")
    axis.set(xlabel="phase of the cycle [°], 0: farthest out", xticks=range(0, 361, 90), xlim=(0, 360))


def shape(axis: "Axes", curve: CurveDocument, look: Look) -> None:
    """Draw the free form of a force that has no name, with two standard errors."""
    position, force, std = (
        np.array(values, dtype=float) for values in (curve.position, curve.force_per_mass, curve.std)
    )
    factor, unit = scale_as_recorded("displacement" if curve.unit == "m" else "", curve.unit)
    axis.fill_between(position * factor, force - 2 * std, force + 2 * std, color=look.noise, lw=0)
    axis.plot(position * factor, force, "o-", color=look.second, ms=3, lw=1.2)
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.set(
        xlabel=literal(f"{curve.coordinate} [{unit}]"),
        ylabel="missing force per unit mass\n(band: 2 std. errors)",
    )


def measured_curve(axis: "Axes", curve: MeasuredCurve, look: Look) -> None:
    """Draw a measured curve of a model with two standard errors."""
    factor, unit = scale_as_recorded("displacement" if curve.unit == "m" else "", curve.unit)
    low, high = curve.value - 2 * curve.std, curve.value + 2 * curve.std
    axis.fill_between(curve.position * factor, low, high, color=look.noise, lw=0)
    axis.plot(curve.position * factor, curve.value, color=look.second, lw=1.5)
    axis.axhline(0, color=look.faint, lw=0.7)
    axis.set(
        xlabel=literal(f"{curve.over} [{unit}]"),
        ylabel=literal(f"measured curve, per unit mass\n[{curve.value_unit}] (band: 2 std. errors)"),
    )
