"""Naming what was hidden: each effect at five strengths, nothing, sensor faults, pairs, and shapes no library has."""

import os
import time
from collections import Counter, defaultdict
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

import numpy as np

from identify.diagnosis.diagnose import diagnose
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.forces import OUTSIDE_THE_LIBRARY, WANDERS
from mocks.generate import PHYSICS, draw
from mocks.sensor_faults import SENSOR_FAULTS

GAIN_UNCERTAINTY = 2e-4
"""The double's sensors are calibrated to this; were it not stated, a gain 1 % off would be a remark and no fault."""

TITLE = "Naming the hidden effect"
BASE = ("linear_stiffness", "coulomb_friction", "viscous_damping")
EFFECTS = tuple(name for name in PHYSICS if name not in BASE)
FAULTS = tuple(name for name in SENSOR_FAULTS if name not in ("channel_lag", "sensor_bandwidth"))
HIDDEN_AT_ONE_FREQUENCY = "maxwell_element"
"""Stiffness and viscous damping at one frequency: see the section on bounds for what can be seen of it at all."""

STRENGTHS = (0.0003, 0.001, 0.003, 0.01, 0.03)
WANDERED = (0.00003, 0.0001, 0.0003, 0.001)
"""Strengths of a random walk; after one second it has about half of it."""

PAIRS = (
    "freeplay+cubic_damping",
    "stribeck_friction+cubic_stiffness",
    "time_varying_stiffness+quadratic_damping",
    "quadratic_stiffness+position_dependent_friction",
    "end_stop+quadratic_damping",
    "hysteresis+cubic_stiffness",
)


@dataclass(frozen=True)
class Case:
    """What is hidden, how strongly, and with which seed; `auto` climbs the ladder instead of one diagnosis."""

    hidden: str | None
    strength: float
    seed: int
    auto: bool = False


@dataclass(frozen=True)
class Outcome:
    """What the station said of a case; `scores` are errors of the parameters in standard errors."""

    case: Case
    verdict: str
    first: str
    named: tuple[str, ...]
    chi_square: float
    seconds: float
    evidence: float
    scores: dict[str, float]


def setting_of(case: Case) -> tuple[PreparedDecay, dict[str, Any]]:
    """Draw a case and make it ready as the station would, and return its truth beside it."""
    sample = draw(case.hidden, case.strength, case.seed)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    return prepare(decay, gain_uncertainty=GAIN_UNCERTAINTY), sample.truth


def judge(case: Case) -> Outcome:
    """Let the station judge one case."""
    began = time.perf_counter()
    try:
        setting, truth = setting_of(case)
        if case.auto:
            ladder = diagnose((setting,)).refine()
            named = tuple(e for e in ladder.top.effects if e not in BASE)
            fit, verdict, first, p = ladder.top.fit, ladder.verdict, named[0] if named else "", 0.0
        else:
            found = diagnose((setting,))
            named, fit, verdict = found.named, found.final, found.verdict
            first, p = found.suspects[0].effect.name, found.suspects[0].evidence
    except (NotIdentifiable, ValueError) as error:
        return Outcome(case, f"refused: {error}", "", (), np.nan, time.perf_counter() - began, 1.0, {})
    return Outcome(
        case, verdict, first, named, fit.reduced, time.perf_counter() - began, p, _scores(fit.values, truth)
    )


def _scores(values: dict[str, Any], truth: dict[str, Any]) -> dict[str, float]:
    known = {
        "linear_stiffness.k": truth["stiffness_per_mass"],
        "coulomb_friction.mu_0": truth["mu_0"],
        "viscous_damping.mu_1": truth["mu_1"],
        "lag": truth["displacement_late_s"],
    }
    parameters = truth["parameters"]
    for effect, inner in parameters.items() if "+" in truth["hidden"] else [(truth["hidden"], parameters)]:
        if isinstance(inner, dict):
            known |= {f"{effect}.{name}": value for name, value in inner.items() if isinstance(value, float)}
    return {
        name: (values[name].value - value) / values[name].std
        for name, value in known.items()
        if name in values and np.isfinite(values[name].std) and values[name].std > 0.0
    }


def judge_all(cases: Iterable[Case]) -> list[Outcome]:
    """Judge cases on all cores, a process each."""
    with ProcessPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(judge, cases, chunksize=4))


def run(quick: bool) -> str:
    """Return the tables as markdown."""
    seeds = 2 if quick else 4
    single = judge_all(Case(e, s, 1000 + i) for e in EFFECTS for s in STRENGTHS for i in range(seeds))
    nothing = judge_all(Case(None, 0.0, 5000 + i) for i in range(20 if quick else 200))
    faults = judge_all(Case(f, s, 2000 + i) for f in FAULTS for s in STRENGTHS[2:] for i in range(seeds))
    pairs = judge_all(Case(p, 0.02, 3000 + i, auto=True) for p in PAIRS for i in range(seeds))
    outside = judge_all(
        Case(o, s, 4000 + i)
        for o in OUTSIDE_THE_LIBRARY
        for s in STRENGTHS[2:]
        for i in range(seeds // 2 or 1)
    )
    wanders = judge_all(
        Case(w, s, 4000 + i) for w in WANDERS for s in WANDERED for i in range(2 if quick else 10)
    )
    return "\n\n".join(
        (
            _by_strength(single),
            _nothing(nothing),
            _faults(faults),
            _pairs(pairs),
            _outside(outside),
            f"A random walk of the spring or the damper, nothing else: {_false_names(wanders)}.",
            _parameters(single),
        )
    )


def _by_strength(outcomes: list[Outcome]) -> str:
    table = defaultdict(Counter)
    for o in outcomes:
        table[o.case.hidden][o.case.strength] += o.first == o.case.hidden
    seeds = len(outcomes) // (len(EFFECTS) * len(STRENGTHS))
    head = (
        "| effect | "
        + " | ".join(f"{100 * s:g} %" for s in STRENGTHS)
        + " |\n|---|"
        + "---|" * len(STRENGTHS)
    )
    always = [e for e in EFFECTS if all(table[e][s] == seeds for s in STRENGTHS[2:])]
    rows = [
        f"| {e} | " + " | ".join(f"{100 * table[e][s] / seeds:.0f}" for s in STRENGTHS) + " |"
        for e in EFFECTS
        if e not in always
    ]
    total = [sum(table[e][s] for e in EFFECTS) / seeds / len(EFFECTS) for s in STRENGTHS]
    rows.append("| **all** | " + " | ".join(f"**{100 * t:.1f}**" for t in total) + " |")
    seen = [e for e in EFFECTS if e != HIDDEN_AT_ONE_FREQUENCY]
    total = [sum(table[e][s] for e in seen) / seeds / len(seen) for s in STRENGTHS]
    rows.append(
        f"| **all but {HIDDEN_AT_ONE_FREQUENCY}** | " + " | ".join(f"**{100 * t:.1f}**" for t in total) + " |"
    )
    told = [
        np.mean([o.case.hidden in o.named for o in outcomes if o.case.strength == strength])
        for strength in STRENGTHS
    ]
    rows.append("| **named by the verdict** | " + " | ".join(f"**{100 * t:.1f}**" for t in told) + " |")
    seconds = np.median([o.seconds for o in outcomes])
    return (
        f"First of the suspects, % of {seeds} seeds, by strength (rms, of the force):\n\n"
        + "\n".join([head, *rows])
        + f"\n\nAlways first from {100 * STRENGTHS[2]:g} % on: {len(always)} of {len(EFFECTS)}. Median time of a diagnosis: {seconds:.1f} s."
    )


def _nothing(outcomes: list[Outcome]) -> str:
    claimed = [o for o in outcomes if o.verdict not in ("nothing_missing", "not_enough_data")]
    said = ", ".join(f"{o.verdict} {'+'.join(o.named)} ({o.evidence:.1f} nats)" for o in claimed) or "none"
    best = np.sort([o.evidence for o in outcomes if np.isfinite(o.evidence)])
    return f"Nothing hidden: an effect or a fault claimed in {len(claimed)} of {len(outcomes)} ({said}). Evidence of the first suspect: at most {best[-1]:.1f} nats, median {np.median(best):.1f}."


def _faults(outcomes: list[Outcome]) -> str:
    named = sum(o.named[:1] == (o.case.hidden,) for o in outcomes)
    physics = sum(o.verdict == "missing_effect" for o in outcomes)
    missed = Counter(
        f"{o.case.hidden} {100 * o.case.strength:g} %: {o.verdict}"
        for o in outcomes
        if o.named[:1] != (o.case.hidden,)
    )
    return (
        f"Sensor faults of 0.3, 1 and 3 %: named in {named} of {len(outcomes)} records, called a force in {physics}. "
        f"Missed: {_counted(missed)}."
    )


def _pairs(outcomes: list[Outcome]) -> str:
    both = [o for o in outcomes if set(o.case.hidden.split("+")) <= set(o.named)]
    within = [o for o in both if len(o.named) <= 3 and o.chi_square < 1.2]
    missed = [f"{o.case.hidden}: {'+'.join(o.named)}" for o in outcomes if o not in within]
    return (
        f"Two effects at once, `--auto`: both found in {len(both)} of {len(outcomes)}, in at most three steps and below "
        f"chi-square 1.2 in {len(within)}. Missed: {'; '.join(missed) or 'none'}."
    )


def _outside(outcomes: list[Outcome]) -> str:
    unknown = sum(o.verdict in ("unknown_effect", "unconfirmed") for o in outcomes) / len(outcomes)
    clean = sum(o.verdict == "nothing_missing" for o in outcomes) / len(outcomes)
    return (
        f"Effects outside the library: {_false_names(outcomes)}; unknown_effect or unconfirmed in {100 * unknown:.0f} %, "
        f"nothing_missing in {100 * clean:.0f} %."
    )


def _false_names(outcomes: list[Outcome]) -> str:
    """Return how many records got a name where every name is false, and which."""
    names = Counter(
        f"{o.case.hidden} {100 * o.case.strength:g} %: {'+'.join(o.named)}" for o in outcomes if o.named
    )
    return f"a false name in {names.total()} of {len(outcomes)} ({_counted(names)})"


def _counted(said: Counter[str]) -> str:
    return "; ".join(f"{what} x{n}" for what, n in said.items()) or "none"


def _parameters(outcomes: list[Outcome]) -> str:
    right = [o for o in outcomes if o.named == (o.case.hidden,)]
    scores = np.array([s for o in right for s in o.scores.values()])
    chi = np.array([o.chi_square for o in right])
    return (
        f"After the right effect ({len(right)} records): chi-square between 0.9 and 1.1 in {100 * np.mean((chi > 0.9) & (chi < 1.1)):.0f} %, "
        f"parameters within 2 standard errors in {100 * np.mean(np.abs(scores) < 2.0):.1f} %."
    )
