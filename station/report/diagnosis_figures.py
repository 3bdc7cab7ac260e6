"""The suspects and the ladder in figures for paper."""

from textwrap import fill

import numpy as np

from identify.diagnosis.force_map import ForceMap
from station.report.drawing import BAND, GREY, INK, MODEL, embedded, literal, paper
from station.results.diagnosis_document import CurveDocument, DiagnosisDocument
from station.results.diagnosis_fits import DiagnosisFits
from station.results.ladder import KeptLadder
from station.text.ladder_text import step
from station.text.numbers import scale_as_recorded, three_figures, typeset_unit
from station.views.suspects import MOST_BARS

LEAST = 0.5


def errors(document: DiagnosisDocument) -> str | None:
    """Draw the chi-square after adding each suspect against the floor; None where there is nothing to draw."""
    rows = [("before", document.error.chi2)]
    rows += [(s.effect, s.error_after) for s in document.suspects]
    known = [(name, value) for name, value in rows if value is not None]
    spread = 0.0 if document.noise_floor is None else document.noise_floor.chi2_std
    return _bars(known[: MOST_BARS + 1], spread, "chi² with it added")


def rungs(ladder: KeptLadder) -> str | None:
    """Draw the chi-square rung by rung down to the floor."""
    rows = [
        (f"{place}: {step(rung)}", rung.error.chi2)
        for place, rung in enumerate(ladder.rungs[: ladder.present + 1])
    ]
    return _bars([(n, float(v)) for n, v in rows if v is not None], ladder.top.chi2_std, "chi²")


def _bars(rows: list[tuple[str, float]], spread: float, label: str) -> str | None:
    if not rows:
        return None
    drawn, (axis,) = paper(0.75 + 0.24 * len(rows))
    values = np.array([value for _, value in rows])
    lengths = np.maximum(values, LEAST * 1.05) - LEAST
    axis.barh(range(len(rows)), lengths, left=LEAST, color="#c4c4c4", edgecolor=INK, lw=0.6, height=0.62)
    for row, value in enumerate(values):
        axis.annotate(f" {three_figures(float(value))}", (max(value, LEAST), row), va="center", fontsize=8)
    axis.axvspan(max(1 - 2 * spread, LEAST), 1 + 2 * spread, color=BAND, lw=0, zorder=0)
    axis.axvline(1, color=INK, lw=1.0, ls="--")
    axis.set_xscale("log")
    axis.set_xlim(LEAST, 2.5 * max(float(values.max()), 2.0))
    axis.set_yticks(range(len(rows)), [literal(name) for name, _ in rows])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel(f"{label} (dashed: the noise floor, 1)")
    return embedded(drawn)


def force_maps(fits: DiagnosisFits) -> str:
    """Draw the force that the model lacks over the cycle beside what the best suspects would add."""
    maps = [("what the model lacks", fits.missing_force())]
    maps += [(term.effect.name, found) for term, found in fits.added_forces()]
    drawn, axes = paper(2.1, 1, len(maps), sharey=True, width=min(6.9, 1.9 * len(maps) + 0.6))
    for axis, (name, found) in zip(axes, maps, strict=True):
        degrees = np.degrees(0.5 * (found.phase[1:] + found.phase[:-1]))
        axis.axhline(0, color=GREY, lw=0.6)
        axis.plot(degrees, found.large, color=INK, lw=1.3, label="large cycles")
        axis.plot(degrees, found.small, color=MODEL, lw=1.1, ls="--", label="small cycles")
        axis.set(xlabel="phase of the cycle [°]", xticks=range(0, 361, 90), xlim=(0, 360))
        axis.set_title(literal(fill(name.replace("_", " "), 20)), fontsize=8)
    reach = _reach(maps[0][1])
    axes[0].set_ylim(-1.5 * reach, 1.5 * reach)
    axes[0].set_ylabel(literal(f"force per unit\nmass [{typeset_unit(f'{fits.prepared.window.unit}/s^2')}]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return embedded(drawn)


def _reach(found: ForceMap) -> float:
    values = np.abs(np.concatenate([found.large, found.small]))
    return float(np.nanmax(values)) if np.isfinite(values).any() and np.nanmax(values) > 0 else 1.0


def shape(curve: CurveDocument) -> str:
    """Draw the free form of a force that has no name, with two standard errors."""
    x, force, std = (
        np.array(values, dtype=float) for values in (curve.position, curve.force_per_mass, curve.std)
    )
    factor, name = scale_as_recorded("displacement" if curve.unit == "m" else "", curve.unit)
    drawn, (axis,) = paper(2.4, width=4.2)
    axis.fill_between(x * factor, force - 2 * std, force + 2 * std, color=BAND, lw=0)
    axis.plot(x * factor, force, "o-", color=INK, ms=3, lw=1.0)
    axis.axhline(0, color=GREY, lw=0.6)
    axis.set_xlabel(literal(f"{curve.coordinate} [{typeset_unit(name)}]"))
    axis.set_ylabel("missing force per unit mass\n(band: 2 std. errors)")
    return embedded(drawn)
