"""The guide on hidden cases: releases and minutes to a confirmed right name, and expected evidence against what came."""

import os
import statistics
import sys
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before numpy loads: a process a core is enough

from bench.guide_cases import HIGH, LIMITS_WORDS, LOW, Case, amplitudes, cases
from bench.regimes import wilson

TITLE = "The next release, chosen"
POLICIES = {
    "guide": "by the guide",
    "same": "the guide's first one again and again",
    "grid": "a grid upwards, the sides in turn",
    "random": "at random, evenly between the limits and on both sides",
}
WHOLE = ("guide", "random")
THIRD = 3
"""Who plays all cases; the others play every third, for each takes minutes."""

SAME = 4  # the same amplitude never reaches the upper limit: it is only asked when it has the right verdict
RECORD_S, HANDLING_S = 10.0, 30.0
WORKERS = int(os.environ.get("BENCH_WORKERS", "2"))


@dataclass
class Outcome:
    """What one policy came to on one case; `evidence` has (expected, scatter, achieved) of releases that were foreseen."""

    case: Case
    policy: str
    state: str
    named: tuple[str, ...]
    releases: int
    seconds: float
    evidence: list[tuple[float, float, float]] = field(default_factory=list)
    why: str = ""
    asked: list[float] = field(default_factory=list)
    alike: tuple[tuple[str, ...], ...] = ()

    @property
    def right(self) -> bool:
        return self.case.right(self.state, self.named, *self.alike)

    @property
    def false(self) -> bool:
        return self.case.false(self.state, self.named, *self.alike)


def play(case: Case, policy: str) -> Outcome:
    """Let a policy record and judge until the test is over."""
    from identify.diagnosis.diagnose import diagnose
    from identify.diagnosis.guidance import MOST, first_release, guidance
    from identify.errors import NotIdentifiable
    from identify.planning.experiment import Experiment
    from identify.planning.next_release import Limits

    limits = Limits(LOW, HIGH)
    first = first_release(limits).experiment
    assert first is not None
    plan = [Experiment(a) for a in amplitudes(policy, case.seed, first.amplitude)]
    decays, seconds, told, before, asked = [], 0.0, None, None, []
    evidence: list[tuple[float, float, float]] = []
    found_right = False
    for number in range(MOST):
        if policy == "guide" and number:
            experiment = (
                told.experiment if told is not None and told.experiment is not None else Experiment(HIGH)
            )
        else:
            experiment = plan[number]
        asked.append(round(1e3 * experiment.amplitude, 2))
        seconds += HANDLING_S + RECORD_S * experiment.longer
        try:
            decays.append(case.record(experiment, number))
            found = diagnose(tuple(decays))
        except NotIdentifiable:
            continue
        if policy == "guide" and before is not None and told is not None:
            evidence += _achieved(case, before, told, found)
        told, before = guidance(found, len(decays), limits), found
        found_right |= len(decays) > 1 and case.right(_said(found.verdict), found.named)
        if told.over or (policy == "same" and (found_right or number == SAME - 1)):
            break
    state, named = (told.state, told.named) if told is not None and told.over else ("given_up", ())
    words, alike = (told.words, told.alike) if told is not None else ("", ())
    return Outcome(case, policy, state, named, number + 1, seconds, evidence, words, asked, alike)


def _said(verdict: str) -> str:
    """Return the end that a verdict would be, were it the last."""
    known = {"nothing_missing": "nothing", "unknown_effect": "no_name", "unconfirmed": "no_name"}
    return known.get(verdict, "confirmed")


def _achieved(case, before, told, found) -> list[tuple[float, float, float]]:  # type: ignore[no-untyped-def]
    """Return what was expected of a release if one hypothesis is true, and what it gave; where that is what is hidden."""
    from identify.diagnosis.guidance import what_it_gave

    gave, chosen = what_it_gave(told, before, found), told.chosen
    named = {frozenset(h.names): h.title for h in before.hypotheses}
    if gave is None or chosen.between[0] != named.get(frozenset((case.hidden or "").split("+"))):
        return []
    return [(chosen.best.nats, chosen.best.scatter, gave)]


def outcomes(chosen: list[Case], policies: tuple[str, ...] = POLICIES) -> list[Outcome]:
    """Play all on two cores, printing each as it is done."""
    out = []
    with ProcessPoolExecutor(WORKERS) as pool:
        waiting = {pool.submit(play, case, policy): (case, policy) for case in chosen for policy in policies}
        for future in as_completed(waiting):
            case, policy = waiting[future]
            try:
                o = future.result()
            except Exception as error:  # a crash is an outcome
                o = Outcome(case, policy, "crashed", (), 6, 0.0, why=f"{type(error).__name__}: {error}")
            out.append(o)
            mark = "FALSE" if o.false else "right" if o.right else "open"
            print(
                f"{o.case.title:55} {o.policy:7}{mark:6}{o.state:11}{o.releases} {'+'.join(o.named):40} {o.asked} {o.why[:150]}",
                file=sys.stderr, flush=True,
            )  # fmt: skip
    return out


def run(quick: bool) -> str:
    """Return the tables as markdown, and draw expected against achieved evidence."""
    began = time.perf_counter()
    every = cases()
    few = every[2::5]
    found = outcomes(few) if quick else outcomes(every, WHOLE)
    if not quick:
        found += outcomes(every[::THIRD], tuple(p for p in POLICIES if p not in WHOLE))
    return report(found, draw=not quick) + f"\n\n{time.perf_counter() - began:.0f} s on two cores."


def report(found: list[Outcome], draw: bool) -> str:
    """Return the tables and the calibration."""
    return f"{_policies(found)}\n\n{_calibration([pair for o in found for pair in o.evidence], draw=draw)}"


def _policies(found: list[Outcome]) -> str:
    head = (
        "| who chooses | right | false names (95 %) | releases to a right end: median, mean "
        "(six where none came) | minutes, mean |\n|---|---|---|---|---|"
    )
    rows, means = [], {}
    for policy in POLICIES:
        own = [o for o in found if o.policy == policy]
        if not own:
            continue
        false = sum(o.false for o in own)
        low, high = wilson(false, len(own))
        counts = [o.releases if o.right else 6 for o in own]
        means[policy] = statistics.mean(counts)
        rows.append(
            f"| {policy} | {sum(o.right for o in own)} of {len(own)} | {false} ({100 * low:.0f} to {100 * high:.0f} %) "
            f"| {statistics.median(counts):g}, {means[policy]:.2f} "
            f"| {statistics.mean(o.seconds for o in own) / 60:.1f} |"
        )
    fewer = ""
    if "guide" in means and "random" in means:
        fewer = f"\n\nThe guide takes {100 * (1 - means['guide'] / means['random']):.0f} % fewer releases than random ones."
    return (
        f"{len({o.case for o in found})} hidden cases on the simulated bench (seeds {min(o.case.seed for o in found)} to "
        f"{max(o.case.seed for o in found)}), {LIMITS_WORDS}, at most six releases. "
        "Right is the name that is hidden, nothing where nothing is, no name where the library has none. "
        + "; ".join(f"{policy}: {words}" for policy, words in POLICIES.items() if policy in means and policy != "guide")
        + "\n\n"
        + "\n".join([head, *rows]) + fewer
    )  # fmt: skip


def _calibration(pairs: list[tuple[float, float, float]], draw: bool) -> str:
    from identify.priors import RIVALS_WITHIN

    if not pairs:
        return "No release was foreseen."
    ratios = [got / nats for nats, _, got in pairs if nats > RIVALS_WITHIN]
    near = sum(0.2 <= ratio <= 5.0 for ratio in ratios)
    if draw:
        from bench.guide_picture import expected_and_achieved

        expected_and_achieved(pairs)
    return (
        f"Of {len(ratios)} releases that were expected to distinguish what is hidden, {near} gave that evidence within a factor of 5."
        "\n\n![Expected and achieved evidence](pictures/guide_expected.svg)"
    )
