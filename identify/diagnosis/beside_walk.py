"""A name beside a random walk: whether effects explain more than a spring and damper that never stay quite the same.

Where the floor is sure, some law of the library follows nearly any slow walk of the spring to within the noise, with
thousands of nats. What tells a law is what it explains beyond the walk, each with its evidence. A law that is there
needs no walk beside it; a walk that a law has followed still shows in what the law leaves.
"""

from dataclasses import dataclass, replace

from identify.diagnosis.linear_gain import LINEAR_UP_TO
from identify.diagnosis.suspects import residual_lines
from identify.diagnosis.verdict import Judgement
from identify.effects.effect import Scales
from identify.evidence.marginal_likelihood import evidence
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import scales_of
from identify.fitting.random_walk import RandomWalk, walk_beside
from identify.priors import RIVALS_WITHIN


@dataclass(frozen=True)
class BesideWalk:
    """Two fits, the second with one effect more or several, and what a walk of spring and damper does beside each.

    `gain` (nats) is what the effects explain beyond a walk: its evidence and theirs against its alone.
    """

    before: RandomWalk
    after: RandomWalk
    gain: float

    @classmethod
    def of(cls, before: Fit, after: Fit, scales: Scales) -> "BesideWalk":
        """Return what is gained from the first fit to the second."""
        first, second = walk_beside(before), walk_beside(after)
        return cls(first, second, evidence(before, after, scales) + second.evidence - first.evidence)

    @property
    def is_more(self) -> bool:
        """Whether the effects are distinguishable from a walk: the odds are against one, or they explain more."""
        return self.before.evidence < 0.0 or self.gain > RIVALS_WITHIN


def more_than_a_walk(baseline: Baseline, judged: Judgement) -> bool:
    """Whether forces named at a sure floor are distinguishable from a random walk, together and each beside the others."""
    before, final = baseline.fit, judged.final
    forces = [t.effect.name for t in final.model.terms if t.is_force and t.effect.name not in before.model]
    if not forces:
        return True
    scales = scales_of(baseline.decays[0], residual_lines(before))
    if not BesideWalk.of(before, final, scales).is_more:
        return False
    without = (fit(final.model.minus(name), final.windows, final.point, final.frequency) for name in forces)
    return not judged.together or all(BesideWalk.of(less, final, scales).is_more for less in without)


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
