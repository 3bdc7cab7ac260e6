"""The search for what is missing: one effect, or two together."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from identify.diagnosis.rest_evidence import at_rest, denied
from identify.diagnosis.screening import promising_pairs
from identify.diagnosis.suspects import Candidate, candidate_terms, residual_lines, try_terms
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY
from identify.fitting.baseline import Baseline
from identify.fitting.initial_values import scales_of
from identify.model.model import Term

_BEAM = 3

_LOOKED_AT = 6

_POLISHED_SECONDS = 3

_POLISHED_BESIDE_BEST = 10

_SCREENED = 6


def singles(
    baseline: Baseline,
    library: tuple[Effect, ...] = LIBRARY,
    counted: Callable[[int, int], None] = lambda done, whole: None,
) -> tuple[Candidate, ...]:
    """Return the model refitted with each effect it lacks, best first; `counted` is told how many fits are done."""
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    return try_terms(baseline.decays, baseline.fit, terms, by_gain=True, counted=counted)


@dataclass(frozen=True, eq=False)
class Pair:
    """Two effects together: the second was refitted with the first in the model."""

    first: Candidate
    second: Candidate

    @property
    def plausible(self) -> bool:
        """Whether both are the best names for what they explain."""
        return self.first.plausible and self.second.plausible


def pairs(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...] = LIBRARY
) -> tuple[Pair, ...]:
    """Return the most promising pairs of effects, best first.

    Forces that explain most together, by equation error, are fitted first; unless one of these pairs reaches the floor,
    what goes best with the best single candidates follows, faults of sensors among them. Where the floor is sure, the
    first plausible pair that reaches it ends the search.
    """
    found: list[Pair] = []
    best = _distinct(tried)[0] if tried else None
    for stage in (_screened, _greedy):
        for first, terms in stage(baseline, tried, library):
            polished = _POLISHED_BESIDE_BEST if first is best else _POLISHED_SECONDS
            goal = baseline.highest * first.fit.degrees
            seconds = try_terms(
                baseline.decays, first.fit, terms, polished=polished, goal=goal, promising=stage is _screened
            )
            seconds = _after_rest(baseline, seconds)
            if seconds:
                found.append(Pair(first, seconds[0]))
            if baseline.floor_is_sure and _reached(baseline, found):
                break
        if _reached(baseline, found):
            break
    return tuple(sorted(found, key=lambda pair: (not pair.plausible, pair.second.score)))


def _after_rest(baseline: Baseline, tried: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Return the candidates that the rest before the release allows, in the order of what it adds to their scores."""
    allowed = (c for c in tried if not denied(baseline.decays, c))
    return tuple(sorted(allowed, key=lambda c: c.score - 2.0 * at_rest(baseline.decays, c)))


def _reached(baseline: Baseline, found: list[Pair]) -> bool:
    return any(pair.plausible and baseline.adequate(pair.second.fit) for pair in found)


def _screened(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[tuple[Candidate, tuple[Term, ...]]]:
    """Yield the first of each screened pair with the terms of its second, which is begun from several starts.

    So the one with more inner parameters is the second; of two alike the one that is worse alone.
    """
    ranks = {candidate.name: rank for rank, candidate in enumerate(tried)}
    largest = max(baseline.decays, key=lambda prepared: prepared.amplitude)
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    scales = scales_of(largest, residual_lines(baseline.fit))
    for pair in promising_pairs(largest, baseline.fit.model, terms, scales)[:_SCREENED]:
        if all(name in ranks for name in pair):
            first, second = sorted(
                pair, key=lambda name: (len(tried[ranks[name]].term.effect.inner), ranks[name])
            )
            yield tried[ranks[first]], tuple(term for term in terms if term.effect.name == second)


def _greedy(
    baseline: Baseline, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[tuple[Candidate, tuple[Term, ...]]]:
    """Yield the best single candidates with what may go with them; two forces are left to the screening but once."""
    for rank, first in enumerate(_distinct(tried)):
        terms = candidate_terms(first.fit.model, library, first.fit.windows[0])
        whole = rank == 0 or not first.term.is_force
        yield first, terms if whole else tuple(term for term in terms if not term.is_force)


def _distinct(tried: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Return the first few candidates, plausible ones first: lines can follow anything for a while."""
    return tuple(sorted(tried[:_LOOKED_AT], key=lambda c: (not c.plausible, c.score))[:_BEAM])
