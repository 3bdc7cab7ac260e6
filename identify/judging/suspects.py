"""Suspects: every effect that the model lacks, refitted in turn."""

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, replace

from identify.effects.effect import Effect, Scales
from identify.effects.families import FAMILIES
from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY
from identify.effects.sensor_fault import SensorFault
from identify.evidence import evidence
from identify.fitting.baseline import Baseline, residual_lines
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import scales_of
from identify.judging.beginning import Beginning, begin
from identify.judging.linear_gain import Slope
from identify.model.model import Model, Term
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import CLEAR, SAME

_LEADERS = 3
BEHIND = 2.0
"""Multiple of the best chi-square up to which every suspect is polished to the end: it may be a rival."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect in its best variant, added to a model and refitted, with its evidence (nats) against the model.

    `unit` is the unit of chi-square in which that was counted. `plausible` is False where its values make it the same
    force as another effect; `claimed` says that it may be named.
    """

    term: Term
    fit: Fit
    evidence: float
    plausible: bool
    claimed: bool = False
    unit: float = 1.0

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


@dataclass(frozen=True, eq=False)
class InPlace:
    """The place of one of several effects beside the others: the fit `without` it, and what is `tried` there.

    The effect itself comes first, then what it may be mistaken for, each with its evidence against that fit.
    """

    without: Fit
    tried: tuple[Candidate, ...]


def candidate_terms(model: Model, library: Iterable[Effect], window: FitWindow) -> tuple[Term, ...]:
    """List every effect and variant that the model lacks and that the channels of a window can show.

    Faults that every fit allows for are judged by what it allowed for. Over the segments of a long release each has
    offsets of its own, which leave slow faults of a sensor nothing to explain.
    """
    terms = []
    for effect in library:
        if effect.name in model or not effect.has_meaning_for(window.unit):
            continue
        if isinstance(effect, SensorFault) and (effect.corrected_in_every_fit or window.segment):
            continue
        for variant in effect.variants:
            channel = variant.get("channel")
            if channel is not None and channel not in window.readings:
                continue
            terms.append(Term(effect, variant))
    return tuple(terms)


def singles(
    baseline: Baseline,
    library: tuple[Effect, ...] = LIBRARY,
    counted: Callable[[int, int], None] = lambda done, whole: None,
) -> tuple[Candidate, ...]:
    """Refit the model with each effect that it lacks, best first; `counted` gets the number of fits that are done."""
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    return try_terms(baseline.decays, baseline.fit, terms, by_gain=True, counted=counted)


def try_terms(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    terms: tuple[Term, ...],
    *,
    goal: float | None = None,
    by_gain: bool = False,
    counted: Callable[[int, int], None] = lambda done, whole: None,
) -> tuple[Candidate, ...]:
    """Refit the model with each term added; return the best variant of each effect, best first.

    From most starts the term's inner parameters are held at first, so that all others can make room for it. Then all are
    fitted freely: the most promising few to the end, the others until they creep with twice the best of these still below.
    Where only a `goal` of chi-square counts, a slow fit is stopped. Fits begin at the places of
    the largest linear gains, too, if `by_gain`. `counted` gets how many fits are done, and of how many at most.
    """
    scales = scales_of(decays[0], residual_lines(base))
    slope = Slope.of(base) if by_gain else None
    whole = 2 * len(terms)
    begun: list[Beginning] = []
    for done, term in enumerate(terms, 1):
        begun += begin(decays, base, slope, term, scales, goal or 0.0)
        counted(done, whole)
    begun.sort(key=lambda beginning: beginning.cost)
    whole = len(terms) + len(begun)
    tried: list[Candidate] = []
    enough = goal or 0.0
    for done, beginning in enumerate(begun, len(terms) + 1):
        if goal is None and len({c.name for c in tried}) == _LEADERS:
            enough = BEHIND * min((c.fit.chi_square for c in tried if c.plausible), default=0.0)
        start = dict(zip((u.name for u in beginning.problem.unknowns), beginning.theta.tolist(), strict=True))
        close = beginning.cost <= base.chi_square
        model = beginning.problem.model
        found = fit(model, base.windows, start, base.frequency, near=close, goal=enough)
        tried.append(score_candidate(found, base, beginning.term, scales))
        counted(done, whole)
    best: dict[str, Candidate] = {}
    for candidate in tried:
        if candidate.name not in best or candidate.evidence > best[candidate.name].evidence:
            best[candidate.name] = candidate
    return tuple(sorted(best.values(), key=lambda candidate: -candidate.evidence))


def laws_of_families(baseline: Baseline, members: Collection[str]) -> tuple[Candidate, ...]:
    """Refit the model with the law that it lacks of each family of which one of some effects is a member, best first."""
    scales, model = scales_of(baseline.decays[0], {}), baseline.fit.model
    families = (family for family in FAMILIES if not family.members.keys().isdisjoint(members))
    terms = tuple(Term(f.effect, f.held(scales)) for f in families if f.effect.name not in model)
    return try_terms(baseline.decays, baseline.fit, terms)


def score_candidate(found: Fit, base: Fit, term: Term, scales: Scales) -> Candidate:
    """Weigh a refit against the fit without the term."""
    return Candidate(term, found, evidence(base, found, scales), is_plausible(found, term, scales))


def is_plausible(found: Fit, term: Term, scales: Scales) -> bool:
    """Check that a fit's values of a term do not make it the same force as another effect."""
    values = {name: estimate.value for name, estimate in found.of(term, len(found.windows) - 1).items()}
    at_fault = replace(scales, peaks={term.channel: scales.peaks[term.channel]}) if term.channel else scales
    return term.effect.plausible(values, at_fault)


def is_predicted(candidate: Candidate) -> bool:
    """Check whether a force has exactly the strength of the linear term that it replaces, so has no constant of its own."""
    effect = candidate.term.effect
    part = effect.may_be_all_of if isinstance(effect, ForceEffect) else None
    name = None if part is None else candidate.fit.model.linear_strength(part)
    if name is None:
        return False
    values = candidate.fit.parameters
    whole = values[str(name)].value
    return abs(values[str(candidate.term.strength)].value - whole) < CLEAR * SAME * whole
