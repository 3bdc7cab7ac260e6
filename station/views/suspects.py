"""The Suspects tab: the error after each, and the fingerprint of the residual beside those of the best three."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.text.diagnosis_text import (
    evidence,
    headline,
    indistinguishable,
    is_claimed,
    number,
    probability,
    size,
)
from station.views import log, palette
from station.views.figure import figure, legend

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROOT = "/suspects"
NAME = "Suspects"
BEST = 3
MOST_BARS = 12
SIDE = (-1.15, 1.15)


@dataclass(frozen=True, eq=False)
class Shown:
    """What the tab shows: the diagnosis as a document, the release of the largest amplitude, and its fits.

    `index` is the place of that release among the fits' spans; `best` the first three suspects, each refitted.
    """

    document: dict[str, Any]
    setting: PreparedDecay
    index: int
    base: Fit
    best: tuple[tuple[Term, Fit], ...]


def shown(found: Diagnosis, document: dict[str, Any]) -> Shown:
    """Return what the tab shows of a diagnosis."""
    settings = found.start.decays
    index = int(np.argmax([setting.amplitude for setting in settings]))
    best = tuple((s.term, s.fit) for s in found.suspects[:BEST])
    return Shown(document, settings[index], index, found.start.fit, best)


def write(stream: rr.RecordingStream, told: Shown, root: str = ROOT) -> None:
    """Log the verdict, the errors, the fingerprints, and the shape of what has no name."""
    log.markdown(stream, f"{root}/verdict", words(told.document))
    _errors(stream, told.document, root)
    _fingerprints(stream, told, root)
    if told.document["shape"] is not None and told.document["shape"]["curves"]:
        _shape(stream, told.document["shape"], root)


def _errors(stream: rr.RecordingStream, document: dict[str, Any], root: str) -> None:
    suspects = [s for s in document["suspects"] if _known(s["error_after"])][:MOST_BARS]
    drawn, (axis,) = figure(9.0, 4.0)
    before = document["error"]["chi2"]
    rows = [("the model as it is", before, palette.MEASURED)] if _known(before) else []
    rows += [(s["effect"], s["error_after"], _colour(s, document)) for s in suspects]
    names = [name for name, _, _ in rows]
    values = [float(value) for _, value, _ in rows]
    colours = [colour for _, _, colour in rows]
    for row, (value, colour) in enumerate(zip(values, colours, strict=True)):
        axis.barh(row, max(value, 1e-3), left=0, color=palette.css(colour), height=0.62)
        axis.annotate(f" {size(value)}", (max(value, 1.0), row), va="center", fontsize=8.5, color=palette.INK)
    spread = document["noise_floor"]["chi2_std"]
    axis.axvspan(1 - 2 * spread, 1 + 2 * spread, color=palette.css(palette.FORCE), alpha=0.22)
    axis.axvline(1, color=palette.css(palette.FORCE), lw=1.2)
    axis.set_xscale("log")
    largest = max([*values, 2.0])
    axis.set_xlim(0.5, largest ** (1.18 if largest > 10 else 1.0) * (1.4 if largest <= 10 else 1.0))
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel("chi2 after adding it: 1 is the noise floor (band: 2 standard errors)")
    log.picture(stream, f"{root}/errors", drawn, {"chi2_after": values})


def _known(value: float | None) -> bool:
    return value is not None and bool(np.isfinite(value))


def _colour(suspect: dict[str, Any], document: dict[str, Any]) -> log.Colour:
    if suspect["effect"] in document["named"]:
        return palette.FORCE
    if not is_claimed(suspect):
        return palette.REFERENCE
    return palette.DISPLACEMENT if suspect["kind"] == "physics" else palette.WAVELET


def _fingerprints(stream: rr.RecordingStream, told: Shown, root: str) -> None:
    setting = told.setting
    left = force_left(setting, told.base)
    prints = [("the force that the model lacks", force_map(setting, left), "measured")]
    numbers: dict[str, Any] = {}
    for term, found in told.best:
        added = force_added(setting, told.base, found, term, told.index)
        prints.append((term.effect.name, force_map(setting, added), _leaves(told.document, term)))
        numbers[term.effect.name] = prints[-1][1].force
    numbers["residual"] = prints[0][1].force
    reach = float(np.nanpercentile(np.abs(prints[0][1].force), 98)) or 1.0
    unit = f"{setting.window.unit}/s²"
    drawn, axes = figure(14.0, 5.4, 2, len(prints), sharey=False)
    for column, (name, found_print, leaves) in enumerate(prints):
        mesh = _disc(axes[column], setting, found_print, reach)
        axes[column].set_title(f"{name}\n{leaves}")
        _cycle(axes[len(prints) + column], found_print, reach)
    bar = drawn.colorbar(mesh, ax=axes[: len(prints)], pad=0.01, aspect=30)
    bar.set_label(f"force per unit mass [{unit}]", color=palette.INK)
    bar.ax.tick_params(colors=palette.INK)
    bar.outline.set_visible(False)
    axes[len(prints)].set_ylabel(f"force per unit mass [{unit}]")
    legend(axes[len(prints)], "upper right")
    log.picture(stream, f"{root}/fingerprints", drawn, numbers)


def _leaves(document: dict[str, Any], term: Term) -> str:
    for suspect in document["suspects"]:
        if suspect["effect"] == term.effect.name and (suspect["channel"] or "") == term.channel:
            return f"with it chi2 is {size(suspect['error_after'])}"
    return ""


def _disc(axis: "Axes", setting: PreparedDecay, found: ForceMap, reach: float) -> Any:
    factor, unit = (1e3, "mm") if setting.window.unit == "m" else (1.0, setting.window.unit)
    radius, angle = np.meshgrid(found.amplitude, found.phase, indexing="ij")
    mesh = axis.pcolormesh(
        radius * np.cos(angle) * factor, -radius * np.sin(angle) * setting.frequency, np.ma.masked_invalid(found.force),
        cmap="RdBu_r", vmin=-reach, vmax=reach, rasterized=True,
    )  # fmt: skip
    axis.set(xlabel=f"displacement [{unit}]")
    axis.set_ylabel(f"velocity [{setting.window.unit}/s]", labelpad=1)
    axis.grid(visible=False)
    return mesh


def _cycle(axis: "Axes", found: ForceMap, reach: float) -> None:
    degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
    axis.axhline(0, color=palette.FAINT, lw=0.8)
    axis.plot(degrees, found.large, color=palette.css(palette.ACCELERATION), lw=1.8, label="large cycles")
    axis.plot(degrees, found.small, color=palette.css(palette.DISPLACEMENT), lw=1.8, label="small cycles")
    axis.set(xlabel="phase of the cycle [°], 0: farthest out", xticks=range(0, 361, 90), xlim=(0, 360))
    axis.set_ylim(SIDE[0] * reach, SIDE[1] * reach)


def _shape(stream: rr.RecordingStream, shape: dict[str, Any], root: str) -> None:
    curve = shape["curves"][0]
    position = np.array(curve["position"])
    force, std = np.array(curve["force_per_mass"]), np.array(curve["std"])
    factor, unit = (1e3, "mm") if curve["unit"] == "m" else (1.0, curve["unit"])
    drawn, (axis,) = figure(6.0, 4.0)
    axis.axhline(0, color=palette.FAINT, lw=0.8)
    axis.fill_between(
        position * factor, force - 2 * std, force + 2 * std, color=palette.css(palette.WRONG), alpha=0.3, lw=0
    )
    axis.plot(position * factor, force, "o-", color=palette.css(palette.WRONG), ms=3, lw=1.4)
    axis.set(
        xlabel=f"{curve['coordinate']} [{unit}]",
        ylabel="missing force per unit mass (band: 2 std. errors)",
        title=f"the shape of it: explains {100 * shape['explained']:.0f} % of the rest",
    )
    log.picture(stream, f"{root}/shape", drawn, {"position": position, "force": force, "std": std})


def words(document: dict[str, Any]) -> str:
    """Return the verdict, the reasons and the suspects as markdown."""
    lines = [f"# {headline(document)}", "", document["explanation"], ""]
    rivals = indistinguishable(document)
    if rivals:
        lines += [f"**This record does not tell it from** {', '.join(rivals)}.", ""]
    lines += ["| suspect | chi2 after | evidence | p |", "|---|---:|---:|---:|"]
    lines += [
        f"| {s['effect']} | {size(s['error_after'])} | {evidence(s['evidence'])} | {probability(s['p_value'])} |"
        for s in document["suspects"][:8]
    ]
    if document["suspects"]:
        first = document["suspects"][0]
        lines += ["", f"## {first['effect']}", "", first["title"], ""]
        lines += [f"- {name} = {number(value)}" for name, value in first["parameters"].items()]
    for finding in document["findings"]:
        lines += ["", f"**Sensor**: {finding['title']}; {finding['what_to_do']}."]
    lines += ["", "## Record next", "", document["next_experiment"]]
    return "\n".join(lines)


def tab(told: Shown, root: str = ROOT) -> rrb.Container:
    """Return the layout of the tab."""
    top: list[rrb.View] = [log.shown_picture("The error after adding each", f"{root}/errors")]
    if told.document["shape"] is not None and told.document["shape"]["curves"]:
        top.append(log.shown_picture("What has no name", f"{root}/shape"))
    return rrb.Horizontal(
        log.document("Verdict", f"{root}/verdict"),
        rrb.Vertical(
            rrb.Horizontal(*top),
            log.shown_picture(
                "Fingerprints: the force that the model lacks, and what the best suspects would add",
                f"{root}/fingerprints",
            ),
            row_shares=[1, 1.25],
        ),
        column_shares=[1, 2.6],
        name=NAME,
    )
