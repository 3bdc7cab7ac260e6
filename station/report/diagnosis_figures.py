"""The suspects and the ladder in figures for paper."""

from textwrap import fill
from typing import Any

import numpy as np

from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from station.quantities import shown
from station.report.drawing import BAND, GREY, INK, MODEL, embedded, literal, paper
from station.report.numbers import unit
from station.results.ladder import KeptLadder
from station.text.diagnosis_text import size
from station.text.ladder_text import step
from station.views.suspects import MOST_BARS, Shown

LEAST = 0.5


def errors(document: dict[str, Any]) -> str | None:
    """Draw the chi-square after adding each suspect against the floor; None where there is nothing to draw."""
    rows = [("before", document["error"]["chi2"])]
    rows += [(s["effect"], s["error_after"]) for s in document["suspects"]]
    rows = [(name, float(value)) for name, value in rows if value is not None and np.isfinite(value)]
    return _bars(rows[: MOST_BARS + 1], document["noise_floor"]["chi2_std"], "chi² with it added")


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
        axis.annotate(f" {size(float(value))}", (max(value, LEAST), row), va="center", fontsize=8)
    axis.axvspan(max(1 - 2 * spread, LEAST), 1 + 2 * spread, color=BAND, lw=0, zorder=0)
    axis.axvline(1, color=INK, lw=1.0, ls="--")
    axis.set_xscale("log")
    axis.set_xlim(LEAST, 2.5 * max(float(values.max()), 2.0))
    axis.set_yticks(range(len(rows)), [literal(name) for name, _ in rows])
    axis.invert_yaxis()
    axis.grid(axis="y", visible=False)
    axis.set_xlabel(f"{label} (dashed: the noise floor, 1)")
    return embedded(drawn)


def fingerprints(told: Shown) -> str:
    """Draw the force that the model lacks over the cycle beside what the best suspects would add."""
    setting = told.setting
    prints = [("what the model lacks", force_map(setting, force_left(setting, told.base)))]
    for term, found in told.best:
        added = force_added(setting, told.base, found, term, told.index)
        prints.append((term.effect.name, force_map(setting, added)))
    drawn, axes = paper(2.1, 1, len(prints), sharey=True, width=min(6.9, 1.9 * len(prints) + 0.6))
    for axis, (name, found_print) in zip(axes, prints, strict=True):
        degrees = np.degrees(0.5 * (found_print.phase[1:] + found_print.phase[:-1]))
        axis.axhline(0, color=GREY, lw=0.6)
        axis.plot(degrees, found_print.large, color=INK, lw=1.3, label="large cycles")
        axis.plot(degrees, found_print.small, color=MODEL, lw=1.1, ls="--", label="small cycles")
        axis.set(xlabel="phase of the cycle [°]", xticks=range(0, 361, 90), xlim=(0, 360))
        axis.set_title(literal(fill(name.replace("_", " "), 20)), fontsize=8)
    reach = _reach(prints[0][1])
    axes[0].set_ylim(-1.5 * reach, 1.5 * reach)
    axes[0].set_ylabel(literal(f"force per unit\nmass [{unit(f'{setting.window.unit}/s^2')}]"))
    axes[0].legend(loc="upper right", fontsize=7)
    return embedded(drawn)


def _reach(found: ForceMap) -> float:
    values = np.abs(np.concatenate([found.large, found.small]))
    return float(np.nanmax(values)) if np.isfinite(values).any() and np.nanmax(values) > 0 else 1.0


def shape(curve: dict[str, Any]) -> str:
    """Draw the free form of a force that has no name, with two standard errors."""
    x, force, std = (np.array(curve[key], dtype=float) for key in ("position", "force_per_mass", "std"))
    factor, name = (
        shown("displacement", curve["unit"]) if curve["unit"] in ("m", "rad") else (1.0, curve["unit"])
    )
    drawn, (axis,) = paper(2.4, width=4.2)
    axis.fill_between(x * factor, force - 2 * std, force + 2 * std, color=BAND, lw=0)
    axis.plot(x * factor, force, "o-", color=INK, ms=3, lw=1.0)
    axis.axhline(0, color=GREY, lw=0.6)
    axis.set_xlabel(literal(f"{curve['coordinate']} [{unit(str(name))}]"))
    axis.set_ylabel("missing force per unit mass\n(band: 2 std. errors)")
    return embedded(drawn)
