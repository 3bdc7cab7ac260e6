"""Other noise and other working points: false names where nothing is hidden, and what is still named of 3 %."""

import argparse
import math
import os
import sys
import time
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

from bench import null_p_values
from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw
from mocks.imperfections import IMPERFECTIONS

TITLE = "Other noise, other working points"
WHITE, COARSE, ALL = "white", "12 bits, quiet", "all of them"
NOISES = (WHITE, *IMPERFECTIONS, COARSE, ALL)
POINTS = ("4 Hz", "1 Hz", "40 Hz", "one channel", "no friction", "mid-decay", "angle")
RELEASES = (1, 3, 9)
FEW_NOISES, FEW_POINTS = (WHITE, "one_over_f", ALL), ("4 Hz", "one channel", "no friction", "mid-decay")
"""What a quick run looks at where it cannot look at all."""
EFFECTS = ("cubic_stiffness", "quadratic_damping", "hysteresis", "second_mass", "freeplay")
TRIPLES = (
    "cubic_stiffness+quadratic_damping+stribeck_friction",
    "hysteresis+cubic_stiffness+quadratic_damping",
    "end_stop+cubic_damping+harmonic_forcing",
    "freeplay+quadratic_damping+second_mass",
    "cubic_stiffness+cubic_damping+position_dependent_friction",
    "quadratic_stiffness+hysteresis+freeplay",
    "time_varying_stiffness+quadratic_damping+cubic_stiffness",
    "bilinear_stiffness+stribeck_friction+position_dependent_damping",
)
NEAR_SHAPES = ("power_law_stiffness", "power_law_damping", "bouc_wen_hysteresis", "fading_friction")
STRENGTH, OF_EACH_OF_THREE = 0.03, 0.02
USUAL_HZ = 3.944
"""Frequency of the double's bench: at other frequencies all of it, sampling too, runs in another time."""

OWN_NAMES = {
    "hum": ("mains_hum",),
    "aliased_line": ("mains_hum",),
    "bend": ("sensor_nonlinearity",),
    "bandwidth": ("sensor_bandwidth",),
}
"""What may be named: the imperfection itself is there."""

WORKERS = int(os.environ.get("BENCH_WORKERS", "2"))


@dataclass(frozen=True)
class Case:
    """What is hidden, the noise, the working point, how many releases, and the seed of the first."""

    hidden: str | None
    noise: str
    point: str
    releases: int
    seed: int


@dataclass(frozen=True)
class Outcome:
    """What the station said of a case; `p` is the first suspect's."""

    case: Case
    verdict: str
    named: tuple[str, ...]
    p: float
    chi_square: float
    seconds: float

    @property
    def false(self) -> bool:
        """Whether something is named that is not there; a crash is no better."""
        return self.verdict.startswith("crashed") or not set(self.named) <= self.there

    @property
    def nameless(self) -> bool:
        """Whether something is held to be missing that has no name."""
        return self.verdict in ("unknown_effect", "unconfirmed", "driven")

    @property
    def made_up(self) -> bool:
        """Whether two effects or more are named, of which one at most is there."""
        return len(self.named) > 1

    @property
    def there(self) -> set[str]:
        """What may be named: what is hidden, and the imperfections of the sensors."""
        return set((self.case.hidden or "").split("+")) | set(own_names(self.case.noise))

    @property
    def found(self) -> bool:
        """Whether all that is hidden is among the names, and nothing else but what is there."""
        return set((self.case.hidden or "").split("+")) <= set(self.named) and not self.false


def own_names(noise: str) -> tuple[str, ...]:
    """Return the names that are true of a kind of noise."""
    if noise == ALL:
        return tuple(name for names in OWN_NAMES.values() for name in names)
    return OWN_NAMES.get(noise, ())


def release_of(case: Case, number: int) -> PreparedDecay:
    """Draw one release of a case: of one specimen with one pair of sensors, each from its own height."""
    seed = case.seed + 1000 * number
    strength = OF_EACH_OF_THREE if case.hidden in TRIPLES else STRENGTH
    sample = draw(case.hidden, strength if case.hidden else 0.0, seed, **fixed(case, number))
    u, a = sample.displacement, sample.acceleration
    if case.point == "one channel":
        return prepare(FreeDecay(sample.rate, displacement=u))
    if case.point == "mid-decay":
        first = round(1.7 * sample.rate)
        return prepare(FreeDecay(sample.rate, u[first:], a[first:]))
    if case.point == "angle":
        return prepare(FreeDecay(sample.rate, displacement=u / 0.1, acceleration=a / 0.1, unit="rad"))
    return prepare(FreeDecay(sample.rate, u, a))


def fixed(case: Case, number: int) -> dict[str, Any]:
    """Return what a case pins of the double's bench."""
    drawn = draw(None, 0.0, case.seed, seconds=1.0).truth
    pace = {"1 Hz": 1.0, "40 Hz": 40.0}.get(case.point, USUAL_HZ) / USUAL_HZ
    result: dict[str, Any] = {
        "stiffness": drawn["stiffness_per_mass"] * pace**2,
        "mu_0": drawn["mu_0"] * pace**2,
        "mu_1": drawn["mu_1"] * pace,
        "rate": 256.0 * pace,
        "seconds": 8.0 / pace,
        "rest": 0.75 / pace,
        "noise_displacement": drawn["noise_m"],
        "noise_acceleration": drawn["noise_m_s2"] * pace**2,
        "range_acceleration": 50.0 * pace**2,
        "release_time": drawn["hand_s"] / pace,
        "released_at": drawn["released_at_s"] / pace,
        "lag": drawn["displacement_late_s"] / pace,
        "sensor_pair": case.seed,
    }
    if number:
        result["amplitude"] = drawn["from_m"] * (1.0 - 0.06 * number)
    if case.point == "no friction":
        result |= {"mu_0": 0.0}
    names = IMPERFECTIONS if case.noise == ALL else (case.noise,) if case.noise in IMPERFECTIONS else ()
    result["imperfections"] = names
    if case.noise in (COARSE, ALL):
        result["bits"] = 12
        if case.noise == COARSE:
            steps = 2.0 / 2.0**12
            result["noise_displacement"] = 0.03 * steps * 0.05
            result["noise_acceleration"] = 0.03 * steps * 50.0 * pace**2
    return result


def judge(case: Case) -> Outcome:
    """Let the station judge one case."""
    began = time.perf_counter()
    try:
        found = diagnose(tuple(release_of(case, number) for number in range(case.releases)))
    except Exception as error:  # a crash is an outcome
        kind = "refused" if isinstance(error, NotIdentifiable) else "crashed"
        return Outcome(case, f"{kind}: {error}", (), 1.0, math.nan, time.perf_counter() - began)
    return Outcome(
        case,
        found.verdict,
        found.named,
        found.suspects[0].p_value if found.suspects else 1.0,
        found.final.reduced,
        time.perf_counter() - began,
    )


def judge_all(cases: list[Case]) -> list[Outcome]:
    """Judge cases on two cores, printing each as it is done."""
    out = []
    with ProcessPoolExecutor(WORKERS) as pool:
        for future in as_completed([pool.submit(judge, case) for case in cases]):
            o = future.result()
            out.append(o)
            mark = "FALSE" if o.false else "found" if o.found else "missed" if o.case.hidden else "ok"
            mark = "nameless" if o.nameless and not o.case.hidden else mark
            print(
                f"{o.case.noise:15} {o.case.point:12} x{o.case.releases} {o.case.hidden or '-':18} {o.case.seed} "
                f"{mark:6} {o.verdict} {'+'.join(o.named)} p {o.p:.2g} chi2 {o.chi_square:.3g} {o.seconds:.1f} s",
                file=sys.stderr,
                flush=True,
            )
    return out


def wilson(k: int, n: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, k of n (Wilson 1927)."""
    if n == 0:
        return 0.0, 1.0
    z, p = 1.96, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
    return max(0.0, middle - half), min(1.0, middle + half)


def cases_of(
    noises: tuple[str, ...],
    points: tuple[str, ...],
    releases: tuple[int, ...],
    seeds: int,
    hidden: tuple[str | None, ...] = (None,),
    first: int = 0,
) -> list[Case]:
    """Return every combination."""
    return [
        Case(h, noise, point, count, 60000 + first + i)
        for i in range(seeds)
        for noise in noises
        for point in points
        for count in releases
        for h in hidden
    ]


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


def run(quick: bool) -> str:
    """Return the tables as markdown."""
    few = 1 if quick else 4
    points = FEW_POINTS if quick else POINTS
    single = judge_all(cases_of(NOISES, points, (1,), few, first=100))
    joint = judge_all(
        cases_of(FEW_NOISES if quick else NOISES, POINTS[:1], (3,) if quick else (3, 9), few, first=300)
    )
    effects = judge_all(
        cases_of(FEW_NOISES if quick else NOISES, POINTS[:1] if quick else POINTS, (1,), few, EFFECTS, 600)
    )
    three = judge_all(cases_of(NOISES[:1], POINTS[:1], (1,), few, TRIPLES, 700))
    near = judge_all(cases_of(NOISES[:1], POINTS[:1], (1,), few, NEAR_SHAPES, 800))
    every = (*single, *joint, *effects, *three, *near)
    crashed = sum(o.verdict.startswith("crashed") for o in every)
    return "\n\n".join(
        (
            "Nothing hidden, one release: a name that is not there.",
            _table(single, "noise", "point", "false"),
            "The same: no name, but something is held to be missing.",
            _table(single, "noise", "point", "nameless"),
            "Nothing hidden, several releases of one specimen together, at 4 Hz: a name that is not there.",
            _table(joint, "noise", "releases", "false"),
            f"Said falsely or without a name: {_said([o for o in (*single, *joint) if o.false or o.nameless])}. "
            f"Crashes: {crashed} of {len(every)}.",
            f"Effects of {100 * STRENGTH:g} %, one release: named, and nothing else with them.",
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
