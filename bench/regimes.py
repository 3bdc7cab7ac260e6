"""Other noise and other working points: false names where nothing is hidden, and what is still named of 3 %."""

import argparse
import math
import sys
from collections import Counter, defaultdict
from typing import Any

from bench import null_p_values
from bench.regime_cases import (
    EFFECTS,
    MANY,
    NEAR_SHAPES,
    NOISES,
    OF_EACH_OF_THREE,
    POINTS,
    STRENGTH,
    TRIPLES,
    WHITE,
    Case,
    cases_in_turn,
    cases_of,
)
from bench.regime_outcomes import Outcome, judge_all

TITLE = "Other noise, other working points"


def run(quick: bool) -> str:
    """Return the tables as markdown; a quick run has one case a cell, and takes ten minutes of two idle cores."""
    few = 1 if quick else 4
    single = judge_all(cases_of(NOISES, POINTS, (1,), few, first=100))
    joint = judge_all(_joint(quick, few))
    effects = judge_all(cases_in_turn(1, 600) if quick else cases_of(NOISES, POINTS, (1,), 2, EFFECTS, 600))
    three = judge_all(cases_of((WHITE,), POINTS[:1], (1,), few, TRIPLES, 700))
    near = judge_all(cases_of((WHITE,), POINTS[:1], (1,), 2 * few, NEAR_SHAPES, 800))
    every = (*single, *joint, *effects, *three, *near)
    crashed = sum(o.verdict.startswith("crashed") for o in every)
    false = [o for o in (*single, *joint) if o.false or o.nameless]
    return "\n\n".join(
        (
            "Nothing hidden, one release: a name that is not there.",
            _table(single, "noise", "point", "false"),
            "The same: no name, but something is held to be missing.",
            _table(single, "noise", "point", "nameless"),
            "Nothing hidden, several releases of one specimen together, at 4 Hz: a name that is not there.",
            _table(joint, "noise", "releases", "false"),
            "The same: no name, but something is held to be missing.",
            _table(joint, "noise", "releases", "nameless"),
            f"Said falsely or without a name: {_said(false)}. Crashes: {crashed} of {len(every)}.",
            f"Effects of {100 * STRENGTH:g} %, one release: named, and nothing with them but what the sensors have.",
            _table(effects, "noise", "point", "found"),
            _table(effects, "noise", "hidden", "found"),
            f"Said of the others: {_said([o for o in effects if not o.found])}.",
            f"Three effects of {100 * OF_EACH_OF_THREE:g} % at once, white noise: all three named, and nothing else.",
            _table(three, "hidden", "point", "found"),
            f"Said of the others: {_said([o for o in three if not o.found])}.",
            f"Shapes between the names and outside them, {100 * STRENGTH:g} %: two or three effects made up.",
            _table(near, "hidden", "point", "made_up"),
            f"Said: {_said(near)}.",
            null_p_values.section(40 if quick else 200),
        )
    )


def _joint(quick: bool, few: int) -> list[Case]:
    """Return releases together in which nothing is hidden, three and nine."""
    three = cases_of(NOISES, POINTS[:1], (3,), few, first=300)
    return three + cases_of(MANY if quick else NOISES, POINTS[:1], (9,), 1 if quick else 2, first=300)


def wilson(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, k of n (Wilson 1927)."""
    if n == 0:
        return 0.0, 1.0
    z, p = 1.96, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def _table(outcomes: list[Outcome], rows: str, columns: str, good: str) -> str:
    """Return counts as a markdown table; `good` is the property that is counted."""
    counts: dict[tuple[Any, Any], list[int]] = defaultdict(lambda: [0, 0])
    for o in outcomes:
        cell = counts[getattr(o.case, rows), getattr(o.case, columns)]
        cell[0] += getattr(o, good)
        cell[1] += 1
    down = list(dict.fromkeys(getattr(o.case, rows) for o in sorted(outcomes, key=_order)))
    across = list(dict.fromkeys(getattr(o.case, columns) for o in sorted(outcomes, key=_order)))
    lines = [f"| {rows} | " + " | ".join(str(c) for c in across) + " | all (95 %) |"]
    lines.append("|---|" + "---|" * (len(across) + 1))
    for r in down:
        cells = [counts[r, c] for c in across]
        k, n = sum(c[0] for c in cells), sum(c[1] for c in cells)
        low, high = wilson(k, n)
        text = " | ".join(f"{c[0]} of {c[1]}" if c[1] else "" for c in cells)
        lines.append(f"| {r} | {text} | {k} of {n} ({100 * low:.0f} to {100 * high:.0f} %) |")
    k, n = sum(getattr(o, good) for o in outcomes), len(outcomes)
    low, high = wilson(k, n)
    lines.append(
        f"| **all** | {' | ' * (len(across) - 1)} | {k} of {n} ({100 * low:.0f} to {100 * high:.0f} %) |"
    )
    return "\n".join(lines)


def _order(outcome: Outcome) -> tuple[int, int, int]:
    case = outcome.case
    return NOISES.index(case.noise), POINTS.index(case.point), case.releases


def _said(outcomes: list[Outcome]) -> str:
    said = Counter(
        f"{o.case.hidden or o.case.noise}: {o.verdict} {'+'.join(o.named)}".strip() for o in outcomes
    )
    return "; ".join(f"{what} x{n}" for what, n in said.most_common()) or "none"


def main(arguments: list[str]) -> None:
    """Run a part of it: `python -m bench.regimes --noises white hum --points "4 Hz" --releases 1 3 --seeds 8`."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--noises", nargs="*", default=NOISES)
    parser.add_argument("--points", nargs="*", default=POINTS[:1])
    parser.add_argument("--releases", nargs="*", type=int, default=[1])
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--effects", action="store_true")
    chosen = parser.parse_args(arguments)
    hidden = EFFECTS if chosen.effects else (None,)
    cases = cases_of(
        tuple(chosen.noises), tuple(chosen.points), tuple(chosen.releases), chosen.seeds, hidden, chosen.first
    )
    outcomes = judge_all(cases)
    good = "found" if chosen.effects else "false"
    print(good + "\n" + _table(outcomes, "noise", "point" if len(chosen.points) > 1 else "releases", good))


if __name__ == "__main__":
    main(sys.argv[1:])
