"""The Suspects tab: the error after each, and the map of the missing force beside those of the best three."""

from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.diagnosis.force_map import ForceMap
from identify.formatting import plain_name
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument, ShapeDocument, SuspectDocument
from station.results.diagnosis_fits import DiagnosisFits
from station.story.residual import residual_words, times
from station.text.diagnosis_text import STRENGTH_UNKNOWN, found_in_sensor, headline, not_distinguishable
from station.text.layout import sentence
from station.text.numbers import scale, three_figures, with_unit
from station.views import log, palette, plots
from station.views.figure import figure, legend
from station.views.plots import SCREEN, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROOT = "/suspects"
NAME = "Suspects"
MOST_BARS = 12
SIDE = (-1.15, 1.15)


def write(stream: rr.RecordingStream, fits: DiagnosisFits, root: str = ROOT) -> None:
    """Log the verdict, the errors, the maps of force, and the shape of what has no name."""
    log.markdown(stream, f"{root}/verdict", summary(fits.document))
    _errors(stream, fits.document, root)
    _force_maps(stream, fits, root)
    if fits.document.shape is not None and fits.document.shape.curves:
        _shape(stream, fits.document.shape, root)


def _errors(stream: rr.RecordingStream, document: DiagnosisDocument, root: str) -> None:
    before = document.error.chi2
    rows = [] if before is None else [("the model as it is", before, palette.MEASURED)]
    rows += [
        (s.effect, s.error_after, _colour(s, document))
        for s in document.suspects
        if s.error_after is not None
    ]
    rows = rows[: MOST_BARS + 1]
    colours = [palette.css(colour) for _, _, colour in rows]
    std = 0.0 if document.noise_floor is None else document.noise_floor.chi2_std
    drawn, (axis,) = figure(9.0, 4.0)
    plots.residuals(axis, [(name, value) for name, value, _ in rows], std, SCREEN, colours, " with it")
    log.picture(stream, f"{root}/errors", drawn, {"chi2_after": [value for _, value, _ in rows]})


def _colour(suspect: SuspectDocument, document: DiagnosisDocument) -> log.Colour:
    if suspect.effect in document.named:
        return palette.FORCE
    if not suspect.claimed:
        return palette.REFERENCE
    return palette.DISPLACEMENT if suspect.kind == "physics" else palette.WAVELET


def _force_maps(stream: rr.RecordingStream, fits: DiagnosisFits, root: str) -> None:
    prepared = fits.prepared
    missing = fits.missing_force()
    maps = [("the force that the model lacks", missing, "measured")]
    maps += [(term.effect.name, found, _leaves(fits.document, term)) for term, found in fits.added_forces()]
    numbers = {"residual": missing.force} | {name: found.force for name, found, _ in maps[1:]}
    reach = float(np.nanpercentile(np.abs(missing.force), 98)) or 1.0
    unit = f"{prepared.window.unit}/s²"
    drawn, axes = figure(14.0, 5.4, 2, len(maps), sharey=False)
    for column, (name, found, leaves) in enumerate(maps):
        mesh = _disc(axes[column], prepared, found, reach)
        axes[column].set_title(f"{name}\n{leaves}")
        plots.force_over_cycle(axes[len(maps) + column], found, SCREEN)
        axes[len(maps) + column].set_ylim(SIDE[0] * reach, SIDE[1] * reach)
    bar = drawn.colorbar(mesh, ax=axes[: len(maps)], pad=0.01, aspect=30)
    bar.set_label(literal(f"force per unit mass [{unit}]"), color=palette.INK)
    bar.ax.tick_params(colors=palette.INK)
    bar.outline.set_visible(False)
    axes[len(maps)].set_ylabel(literal(f"force per unit mass [{unit}]"))
    legend(axes[len(maps)], "upper right")
    log.picture(stream, f"{root}/force_maps", drawn, numbers)


def _leaves(document: DiagnosisDocument, term: Term) -> str:
    for suspect in document.suspects:
        if suspect.effect == term.effect.name and (suspect.channel or "") == term.channel:
            return f"leaves {residual_words(suspect.motion_percent, suspect.error_after)}"
    return ""


def _disc(axis: "Axes", prepared: PreparedDecay, found: ForceMap, reach: float) -> Any:
    factor, unit = scale("displacement", prepared.window.unit)
    radius, angle = np.meshgrid(found.amplitude, found.phase, indexing="ij")
    mesh = axis.pcolormesh(
        radius * np.cos(angle) * factor, -radius * np.sin(angle) * prepared.frequency, np.ma.masked_invalid(found.force),
        cmap="RdBu_r", vmin=-reach, vmax=reach, rasterized=True,
    )  # fmt: skip
    axis.set(xlabel=literal(f"displacement [{unit}]"))
    axis.set_ylabel(literal(f"velocity [{prepared.window.unit}/s]"), labelpad=1)
    axis.grid(visible=False)
    return mesh


def _shape(stream: rr.RecordingStream, shape: ShapeDocument, root: str) -> None:
    curve = shape.curves[0]
    drawn, (axis,) = figure(6.0, 4.0)
    plots.shape(axis, curve, SCREEN)
    axis.set_title(f"the free form explains {100 * shape.explained:.0f} % of the rest")
    numbers = {"position": curve.position, "force": curve.force_per_mass, "std": curve.std}
    log.picture(stream, f"{root}/shape", drawn, numbers)


def summary(document: DiagnosisDocument) -> str:
    """Return the verdict, the reasons and the suspects as markdown."""
    lines = [f"# {headline(document)}", "", f"In {document.model_is}. {document.explanation}", ""]
    if document.rivals:
        lines += [f"**{sentence(not_distinguishable(document))}**", ""]
    lines += ["| with | residual, % of motion | times the noise |", "|---|---:|---:|"]
    lines += [
        f"| {plain_name(s.effect)} | {three_figures(s.motion_percent)} | {times(s.error_after)} |"
        for s in document.suspects[:8]
    ]
    if document.suspects:
        first = document.suspects[0]
        lines += ["", f"## {plain_name(first.effect)} (`{first.effect}`)", "", first.title, ""]
        values = [f"{name} = {with_unit(value)}" for name, value in first.parameters.items()]
        lines += [f"- {line}" for line in (values if first.strength_known else [STRENGTH_UNKNOWN])]
    for finding in document.findings:
        lines += ["", f"**Sensor**: {found_in_sensor(finding)}; {finding.what_to_do}."]
    lines += ["", "## Record next", "", document.next_experiment]
    return "\n".join(lines)


def tab(fits: DiagnosisFits, root: str = ROOT) -> rrb.Container:
    """Return the layout of the tab."""
    top: list[rrb.View] = [log.shown_picture("The error after adding each", f"{root}/errors")]
    if fits.document.shape is not None and fits.document.shape.curves:
        top.append(log.shown_picture("What has no name", f"{root}/shape"))
    return rrb.Horizontal(
        log.document("Verdict", f"{root}/verdict"),
        rrb.Vertical(
            rrb.Horizontal(*top),
            log.shown_picture(
                "Maps of force: the force that the model lacks, and what the best suspects would add",
                f"{root}/force_maps",
            ),
            row_shares=[1, 1.25],
        ),
        column_shares=[1, 2.6],
        name=NAME,
    )
