"""Pictures for a notebook: `draw(result)` gives a figure of whatever `identify` returned."""

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np

from station.views import figure  # noqa: F401  which imports matplotlib, before anyone else does

# isort: split
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from identify.comparison.compare import Comparison
from identify.curves.laid_over import DecayCurves
from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.diagnosis.ladder import Ladder
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.restoring_force.restoring_force import RestoringForceResult
from identify.wavelet.wavelet import WaveletResult
from station.views import plots
from station.views.curve_panels import draw_panels
from station.views.plots import PAPER, literal

WIDTH = 7.5
MOST_SUSPECTS = 3
DOTS_PER_INCH = 110
MEASURED, MODEL = PAPER.measured, PAPER.model


class Picture(Figure):
    """A figure that a notebook shows by itself; `savefig` writes it to a file."""

    def _repr_png_(self) -> bytes:
        stream = BytesIO()
        self.savefig(stream, format="png", dpi=DOTS_PER_INCH)
        return stream.getvalue()


def draw(
    result: FreeDecay
    | PreparedDecay
    | WaveletResult
    | RestoringForceResult
    | Comparison
    | DecayCurves
    | Diagnosis
    | Ladder,
) -> Picture:
    """Return a picture of a result of `identify`; TypeError where there is none for it."""
    for kind, drawing in _DRAWINGS:
        if isinstance(result, kind):
            return drawing(result)
    raise TypeError(f"there is no picture of a {type(result).__name__}")


def _axes(height: float, rows: int = 1, columns: int = 1, **how: Any) -> tuple[Picture, list[Axes]]:
    picture = Picture(figsize=(WIDTH, height), layout="constrained")
    made = np.atleast_1d(picture.subplots(rows, columns, **how)).ravel().tolist()
    for axes in made:
        axes.grid(visible=True, color="#dddddd", linewidth=0.5)
        axes.set_axisbelow(True)
        axes.spines[["top", "right"]].set_visible(False)
    return picture, made


def _free_decay(decay: FreeDecay) -> Picture:
    units = {"displacement": decay.unit, "velocity": f"{decay.unit}/s", "acceleration": f"{decay.unit}/s²"}
    present = [name for name in units if getattr(decay, name) is not None]
    picture, axes = _axes(1.7 * len(present) + 0.4, len(present), sharex=True)
    for axis, name in zip(axes, present, strict=True):
        axis.plot(decay.time, getattr(decay, name), color=MEASURED, linewidth=0.8)
        axis.set_ylabel(literal(f"{name} [{units[name]}]"))
        if decay.start:
            axis.axvline(
                decay.start / decay.rate, color=MODEL, linewidth=0.8, linestyle="--", label="release"
            )
            axis.legend(frameon=False, loc="upper right")
    axes[-1].set_xlabel("time [s]")
    return picture


def _prepared(prepared: PreparedDecay) -> Picture:
    motion, unit = prepared.motion, prepared.window.unit
    picture, axes = _axes(3.2, 1, 2)
    axes[0].plot(prepared.time, motion.displacement, color=MEASURED, linewidth=0.8)
    axes[0].set(xlabel="time since the release [s]", ylabel=literal(f"displacement [{unit}]"))
    axes[1].plot(motion.displacement, prepared.restoring, ".", color=MEASURED, markersize=1.5)
    axes[1].set(
        xlabel=literal(f"displacement [{unit}]"), ylabel=literal(f"restoring force per unit mass [{unit}/s²]")
    )
    return picture


def _wavelet(found: WaveletResult) -> Picture:
    picture, axes = _axes(3.2, 1, 2)
    axes[0].semilogy(found.time, found.envelope, color=MEASURED, linewidth=2.5, label="measured")
    axes[0].semilogy(found.time, found.envelope_fit, color=MODEL, linewidth=1.0, label="model")
    axes[0].set(xlabel="time [s]", ylabel=f"envelope of the {found.channel} (SI)")
    axes[0].legend(frameon=False)
    trusted = found.trusted
    axes[1].plot(found.time[trusted], found.frequency[trusted], color=MEASURED, linewidth=1.0)
    axes[1].set(xlabel="time [s]", ylabel="instantaneous frequency [Hz]")
    return picture


def _restoring_force(found: RestoringForceResult) -> Picture:
    picture, axes = _axes(3.2, 1, 2)
    sections = (
        (axes[0], found.section_zero_velocity, "displacement, at zero velocity (SI)"),
        (axes[1], found.section_zero_displacement, "velocity, at zero displacement (SI)"),
    )
    for axis, section, name in sections:
        plots.force_section(axis, section, 1.0, PAPER)
        axis.set_xlabel(name)
    axes[0].set_ylabel("restoring force per unit mass (SI)")
    axes[0].legend(frameon=False)
    return picture


def _comparison(found: Comparison) -> Picture:
    picture, axes = _axes(3.4, 1, 2)
    plane, unit = found.phase_plane, found.unit
    factor, length = (1e3, "mm") if unit == "m" else (1.0, unit)
    reach = float(np.nanmax(np.abs(plane.force))) if np.isfinite(plane.force).any() else 1.0
    mesh = axes[0].pcolormesh(
        factor * plane.displacement_edges,
        plane.velocity_edges,
        plane.force,
        cmap="RdBu_r",
        vmin=-reach,
        vmax=reach,
    )
    picture.colorbar(mesh, ax=axes[0], label=literal(f"missing force per unit mass [{unit}/s²]"))
    axes[0].set(xlabel=literal(f"displacement [{length}]"), ylabel=literal(f"velocity [{unit}/s]"))
    axes[1].plot(found.cycles.time, found.free_run_misfit, "o-", color=MODEL, markersize=3)
    axes[1].axhline(1.0, color=MEASURED, linestyle="--", linewidth=0.8, label="noise")
    axes[1].set(xlabel="time since the release [s]", ylabel="free-run misfit [noise rms]", yscale="log")
    axes[1].legend(frameon=False)
    return picture


def _diagnosis(found: Diagnosis) -> Picture:
    place = int(np.argmax([prepared.amplitude for prepared in found.baseline.decays]))
    prepared, base = found.baseline.decays[place], found.baseline.fit
    panels = [("missing", force_map(prepared, force_left(prepared, base)))]
    tried = [s for s in found.suspects if s.effect.name in s.fit.model][:MOST_SUSPECTS]
    for suspect in tried:
        force = force_added(prepared, base, suspect.fit, suspect.term, place)
        panels.append((suspect.effect.name.replace("_", " "), force_map(prepared, force)))
    reach = max(_reach(panel) for _, panel in panels)
    picture, axes = _axes(2.6, 1, len(panels), sharey=True)
    for axis, (title, panel) in zip(axes, panels, strict=True):
        degrees = np.degrees(panel.phase)
        mesh = axis.pcolormesh(degrees, panel.amplitude, panel.force, cmap="RdBu_r", vmin=-reach, vmax=reach)
        axis.set_title(title, fontsize=9)
        axis.set_xticks([0, 180, 360])
        axis.grid(visible=False)
    unit = prepared.window.unit
    axes[0].set_ylabel(literal(f"amplitude [{unit}]"))
    axes[len(panels) // 2].set_xlabel("phase of the cycle [°]")
    picture.colorbar(mesh, ax=axes, label=literal(f"force per unit mass [{unit}/s²]"))
    return picture


def _reach(panel: ForceMap) -> float:
    return float(np.nanmax(np.abs(panel.force))) if np.isfinite(panel.force).any() else 0.0


def _curves(found: DecayCurves) -> Picture:
    picture, axes = _axes(3.6, 1, 2)
    names = [f"release {1 + n}" for n in range(1 + max(curve.release for curve in found.releases))]
    draw_panels(axes, found, names, PAPER)
    return picture


def _ladder(found: Ladder) -> Picture:
    names = [
        f"+ {step.added}" if step.added else f"- {step.removed}" if step.removed else "model to begin with"
        for step in found.steps
    ]
    rows = [(name, step.error.chi_square) for name, step in zip(names, found.steps, strict=True)]
    colours = [MODEL if step.at_floor else MEASURED for step in found.steps]
    picture, (axis,) = _axes(0.5 * len(names) + 1.0)
    plots.residuals(axis, rows, found.top.error.floor_std, PAPER, colours)
    return picture


_DRAWINGS: tuple[tuple[type, Callable[[Any], Picture]], ...] = (
    (FreeDecay, _free_decay),
    (PreparedDecay, _prepared),
    (WaveletResult, _wavelet),
    (RestoringForceResult, _restoring_force),
    (Comparison, _comparison),
    (DecayCurves, _curves),
    (Diagnosis, _diagnosis),
    (Ladder, _ladder),
)
