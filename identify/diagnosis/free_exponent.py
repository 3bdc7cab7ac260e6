"""Laws of a free exponent, for shapes between the names: each begun from the named effects that are members of it.

From afar a law whose exponent is free may be lost: a power of nearly one is a linear spring. The named effects have been
fitted already, and the best of them is near.
"""

from collections.abc import Iterator

from identify.diagnosis.suspects import Candidate, residual_lines, score_candidate, try_terms
from identify.effects.families import FAMILIES
from identify.effects.family import Family
from identify.fitting.baseline import Baseline
from identify.fitting.fit import fit
from identify.fitting.initial_values import scales_of
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

_MEMBERS = 2
_NEAR_BEST = 10.0
"""Multiple of what the best named effect leaves up to which a member is worth to begin from."""


def families(baseline: Baseline, tried: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Return the model refitted with laws of a free exponent, best first.

    `tried` are the named effects as fitted. Where none of the laws begun from its members comes to the floor, all are
    tried from starting values of their own, as any other effect is.
    """
    goal = baseline.highest * baseline.fit.degrees
    found = [candidate for family in FAMILIES for candidate in from_members(baseline, family, tried, goal)]
    if not any(c.plausible and baseline.adequate(c.fit) for c in found):
        scales = scales_of(baseline.decays[0], {})
        terms = tuple(Term(family.effect, family.held(scales)) for family in FAMILIES)
        found += try_terms(baseline.decays, baseline.fit, terms, goal=goal)
    return tuple(sorted(found, key=lambda candidate: -candidate.evidence))


def from_members(
    baseline: Baseline, family: Family, tried: tuple[Candidate, ...], goal: float
) -> Iterator[Candidate]:
    """Yield the model refitted with a law of a free exponent, begun from those members of it that were `tried`."""
    enough = _NEAR_BEST * min((c.fit.chi_square for c in tried), default=0.0)
    members = [c for c in tried if c.name in family.members and c.fit.chi_square <= enough]
    term = Term(family.effect, family.held(scales_of(baseline.decays[0], {})))
    scales = scales_of(baseline.decays[0], residual_lines(baseline.fit))
    for member in sorted(members, key=lambda c: c.fit.chi_square)[:_MEMBERS]:
        start = _start(baseline.decays, family, term, member)
        model = Model((*baseline.fit.model.terms, term))
        whole = fit(model, baseline.fit.windows, start, baseline.fit.frequency, near=True, goal=goal)
        yield score_candidate(whole, baseline.fit, term, scales)


def _start(
    decays: tuple[PreparedDecay, ...], family: Family, term: Term, member: Candidate
) -> dict[str, float]:
    """Return the values of a member's fit as those of the law at the member's exponent, of as much force."""
    own = {name: estimate.value for name, estimate in member.fit.of(member.term).items()}
    inner = {p.name: own[p.name] for p in term.free[1:] if p.name in own}
    inner[family.exponent] = family.members[member.name]
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    path = (largest.time, largest.motion.displacement, largest.motion.velocity, largest.frequency)
    there, here = force_along(member.term, own, *path), force_along(term, inner, *path)
    share = float(there @ here) / max(float(here @ here), 1e-300)
    values = {**inner, term.effect.strength.name: share * own[member.term.effect.strength.name]}
    states = {
        name.replace(f"{member.name}.", f"{term.effect.name}.", 1): value
        for name, value in member.fit.point.items()
        if name.startswith(f"{member.name}.state")
    }
    return member.fit.point | states | term.by_name(values)
