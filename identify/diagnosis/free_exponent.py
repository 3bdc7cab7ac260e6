"""Laws of a free exponent, for shapes between the names."""

from collections.abc import Collection

from identify.diagnosis.suspects import Candidate, try_terms
from identify.effects.families import FAMILIES
from identify.fitting.baseline import Baseline
from identify.fitting.initial_values import scales_of
from identify.model.model import Term


def laws_of_free_exponent(
    baseline: Baseline, members: Collection[str], goal: float | None = None
) -> tuple[Candidate, ...]:
    """Refit the model with each law of a free exponent of which one of some effects is a member, best first.

    Where only a `goal` of chi-square counts, a fit that creeps towards it is left.
    """
    scales = scales_of(baseline.decays[0], {})
    families = (family for family in FAMILIES if not family.members.keys().isdisjoint(members))
    terms = tuple(Term(family.effect, family.held(scales)) for family in families)
    return try_terms(baseline.decays, baseline.fit, terms, goal=goal)
