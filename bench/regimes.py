"""Other noise and other working points: false names where nothing is hidden, and what is still named of 3 %."""

import argparse
import math
import sys
from collections import Counter

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
            f"Every kind of noise at every working point, nothing hidden: a name in {_share(single, 'false')}, a missing force "
            f"without a name in {_share(single, 'nameless')}. Three or nine releases together: {_share(joint, 'false')} and "
            f"{_share(joint, 'nameless')}: {_said(false)}. Crashes: {crashed} of {len(every)}.",
            f"An effect of {100 * STRENGTH:g} % is named, and nothing else but real sensor faults, in "
            f"{_share(effects, 'found')}. Not: {_said([o for o in effects if not o.found])}.",
            f"Three effects of {100 * OF_EACH_OF_THREE:g} % at once, white noise, 4 Hz: found in {_share(three, 'found')}. "
            f"Not found: {_said([o for o in three if not o.found])}.",
            f"Laws between the names, {100 * STRENGTH:g} %: several effects named in {_share(near, 'made_up')}. Verdicts: {_said(near)}.",
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


def _table(by: str, columns: dict[str, tuple[list[Outcome], str]]) -> str:
    """Return counts as a markdown table, `k/n` a cell: a column counts one property of its outcomes."""
    every = sorted((o for outcomes, _ in columns.values() for o in outcomes), key=_order)
    lines = [f"| {by} | {' | '.join(columns)} |", "|---|" + "---:|" * len(columns)]
    for value in dict.fromkeys(getattr(o.case, by) for o in every):
        cells = (
            _count([o for o in outcomes if getattr(o.case, by) == value], good)
            for outcomes, good in columns.values()
        )
        lines.append(f"| {value} | {' | '.join(cells)} |")
    return "\n".join([*lines, f"| **all** | {' | '.join(_share(*column) for column in columns.values())} |"])


def _count(outcomes: list[Outcome], good: str) -> str:
    return f"{sum(getattr(o, good) for o in outcomes)}/{len(outcomes)}" if outcomes else ""


def _share(outcomes: list[Outcome], good: str) -> str:
    """Return a count with the 95 % interval of its share."""
    low, high = wilson(sum(getattr(o, good) for o in outcomes), len(outcomes))
    return f"{_count(outcomes, good)} ({100 * low:.0f} to {100 * high:.0f} %)"


def _order(outcome: Outcome) -> tuple[int, int, int]:
    case = outcome.case
    return NOISES.index(case.noise), POINTS.index(case.point), case.releases


def _said(outcomes: list[Outcome]) -> str:
    said = Counter(
        f"{o.case.hidden or o.case.noise}, {o.case.point}: {o.verdict} {'+'.join(o.named)}".strip()
        for o in outcomes
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
    across = "point" if len(chosen.points) > 1 else "releases"
    columns = dict.fromkeys(str(getattr(o.case, across)) for o in sorted(outcomes, key=_order))
    split = {c: ([o for o in outcomes if str(getattr(o.case, across)) == c], good) for c in columns}
    print(good + "\n" + _table("noise", split))


if __name__ == "__main__":
    main(sys.argv[1:])
