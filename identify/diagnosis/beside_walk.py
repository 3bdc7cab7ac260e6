"""A name beside what has none: whether effects explain more than a random walk of spring and damper and a smooth law.

Where the floor is sure, some law of the library follows nearly any slow walk of the spring, and nearly any smooth law that
the library does not hold, to within the noise, with thousands of nats. What tells a law is what it explains beyond both,
and that it leaves nothing to explain. A law that is there needs no walk beside it; a walk that a law has followed still
shows in what the law leaves.
"""

from dataclasses import dataclass, replace

from identify.diagnosis.linear_gain import LINEAR_UP_TO
from identify.diagnosis.suspects import residual_lines
from identify.diagnosis.verdict import Judgement
from identify.effects.effect import Effect
from identify.evidence.evidence import Evidence, decide
from identify.evidence.marginal_likelihood import evidence
from identify.evidence.smooth_law import smooth_law_beside
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import scales_of
from identify.fitting.random_walk import RandomWalk, walk_beside
from identify.priors import RIVALS_WITHIN


@dataclass(frozen=True)
class WithoutName:
    """What may be there beside a fit and has no name: a random walk of spring and damper, and a smooth law beside that."""

    walk: RandomWalk
    law: float

    @classmethod
    def beside(cls, found: Fit) -> "WithoutName":
        """Weigh both beside a fit, the law in nats."""
        walk = walk_beside(found)
        return cls(walk, smooth_law_beside(found, walk))


def weigh(before: Fit, nats: dict[str, float], effects: dict[str, Effect], last: WithoutName) -> Evidence:
    """Decide what is named of some effects with the evidence `nats` against the fit before; a walk is beside all and none.

    `last` is what the leader leaves: the others explain as much, and leave as much.
    """
    first = WithoutName.beside(before)
    shift = last.walk.evidence - first.walk.evidence
    return decide(
        {name: one + shift for name, one in nats.items()},
        effects,
        unnamed=first.law,
        beside=last.law,
        drift_weighed=True,
    )


def may_be_named(baseline: Baseline, judged: Judgement) -> bool:
    """Whether what is named at a sure floor is more than a walk or a law without a name, and each beside the others."""
    final = judged.final
    added = [term.effect for term in final.model.terms if term.effect.name not in baseline.fit.model]
    if not added:
        return True
    last = WithoutName.beside(final)
    if len(added) == 1:
        near = [one for one in judged.ranked if one.claimed and one.candidate.plausible]
        effects = {one.candidate.name: one.candidate.term.effect for one in near}
        nats = {one.candidate.name: one.evidence for one in near}
        return weigh(baseline.fit, nats, effects, last).verdict == "named"
    scales = scales_of(baseline.decays[0], residual_lines(baseline.fit))
    for effect in added:
        less = fit(final.model.minus(effect.name), final.windows, final.point, final.frequency)
        nats = {effect.name: evidence(less, final, scales)}
        if weigh(less, nats, {effect.name: effect}, last).verdict != "named":
            return False
    return True


def with_walk(baseline: Baseline, judged: Judgement) -> Judgement:
    """Return a judgement without a name, with the random walk that explains all of the misfit, where one does."""
    near = baseline.floor_is_sure and baseline.fit.reduced < LINEAR_UP_TO
    if judged.verdict != "unknown_effect" or not near:
        return judged
    alone = walk_beside(baseline.fit)
    enough = alone.evidence > RIVALS_WITHIN and alone.reduced <= baseline.highest
    return replace(judged, walk=alone) if enough else judged


def walk_sentence(walk: RandomWalk | None, *, named: bool, releases: int) -> str:
    """Return what a walk explains, of what a name leaves or instead of a name; "" where none is told of."""
    if walk is None or not (walk.stiffness or walk.damping):
        return ""
    drifts = []
    if walk.stiffness:
        drifts.append(f"in stiffness of about {_one_figure(100.0 * walk.stiffness)} %")
    if walk.damping:
        drifts.append(f"in damping ratio of about {_one_figure(0.5 * walk.damping)}")
    drift = f"a random drift {' and '.join(drifts)} in one second"
    if named:
        return f"What is left is what {drift} would leave."
    apart = "Such a drift never comes twice alike, so several releases tell a law from it."
    return f"It may be no law at all: {drift} explains it as well.{f' {apart}' if releases == 1 else ''}"


def _one_figure(value: float) -> str:
    """Return a size that is known to a factor of two."""
    return f"{value:.0f}" if value >= 1.0 else f"{value:.1g}"
