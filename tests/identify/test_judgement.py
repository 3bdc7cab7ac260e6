"""The judgement: rivals are claimed and as good; a pair is named only where it is better than the best single effect."""

from dataclasses import dataclass, replace

import pytest
from releases import drawn

from identify.diagnosis import several_effects
from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.judgement import judge
from identify.diagnosis.ranking import RIVALS_WITHIN, Ranked, rank, rivals_of
from identify.diagnosis.search import Pair, chances, singles
from identify.effects.library import LIBRARY, find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.model_error import motion_percent
from identify.model.model import Term, base_model

FORCES = tuple(find_effect(name) for name in ("cubic_stiffness", "quadratic_damping", "stribeck_friction"))


@dataclass
class Named:
    name: str


def entry(name: str, evidence: float, claimed: bool = True) -> Ranked:
    return Ranked(Named(name), evidence, 0.0 if claimed else 1.0, claimed)  # type: ignore[arg-type]


def test_rivals_are_claimed_and_their_evidence_is_as_good():
    first = entry("a", 50.0)
    near, far = entry("b", 50.0 - 0.9 * RIVALS_WITHIN), entry("c", 50.0 - 1.1 * RIVALS_WITHIN)
    weak = entry("d", 49.0, claimed=False)
    everything = (first, near, far, weak)
    assert rivals_of(first, everything) == ("b",)
    assert rivals_of(near, everything) == ("a", "c")
    assert rivals_of(weak, everything) == ()


@pytest.mark.parametrize("better", [False, True])
def test_a_pair_counts_only_where_it_is_better_than_the_best_single_effect(better, monkeypatch):
    prepared, _ = drawn("freeplay+cubic_damping", 0.02, seed=44)
    baseline = fit_baseline((prepared,), base_model())
    chance = chances(baseline, FORCES)
    tried = singles(baseline, chance, FORCES)
    ranked = rank(baseline, tried, chance)
    best, other = ranked[0].candidate, tried[-1]
    assert not baseline.adequate(best.fit)
    pair = Pair(best, replace(other, plausible=True, score=best.score + (-100.0 if better else 100.0)))
    monkeypatch.setattr(several_effects, "pairs", lambda *given: (replace(pair),))
    judged = judge(baseline, ranked, (), LIBRARY, lambda: None)
    assert judged.final is (other.fit if better else best.fit)


def test_a_weak_fault_of_a_sensor_is_claimed_only_where_the_floor_is_sure():
    prepared, _ = drawn(None, 0.0, 5001)
    sure = fit_baseline((prepared,), base_model())
    noise = {name: replace(one, source="guess") for name, one in prepared.noise.items()}
    guessed = replace(sure, decays=(replace(prepared, noise=noise),))
    assert sure.floor_is_sure
    assert not guessed.floor_is_sure
    weak = CorrectedFault(Term(find_effect("channel_gain")), 14.0, 0, {})  # by chance once in 150
    strong = replace(weak, drop=40.0)
    for baseline, fault, verdict in (
        (sure, weak, "sensor_fault"),
        (guessed, weak, "nothing_missing"),
        (guessed, strong, "sensor_fault"),
    ):
        assert judge(baseline, (), (fault,), LIBRARY, lambda: None).verdict == verdict


def test_a_force_that_is_sure_but_small_is_named_with_what_it_removes_or_not_where_more_is_asked():
    prepared, _ = drawn("cubic_stiffness", 0.001, 44)
    found = diagnose((prepared,), library=FORCES)
    assert found.named == ("cubic_stiffness",)
    before, after = motion_percent(found.baseline.fit), motion_percent(found.final)
    removed = (before**2 - after**2) ** 0.5
    assert removed < 0.5
    assert f"from {before:.3g} to {after:.3g} % of the motion" in found.explanation
    assert f"That is little, {removed:.3g} % of the motion" in found.explanation
    assert diagnose((prepared,), library=FORCES, worth=0.9 * removed).named == ("cubic_stiffness",)
    small = diagnose((prepared,), library=FORCES, worth=1.1 * removed)
    assert (small.verdict, small.named) == ("nothing_missing", ())
    assert not any(suspect.claimed for suspect in small.suspects)
    assert small.explanation.startswith(
        f"Cubic stiffness is sure, but removes {removed:.3g} % of the motion only"
    )
    ladder = small.refine()
    assert len(ladder.rungs) == 1
    assert ladder.stopped_because == "what is left is too little of the motion to be worth a name"
