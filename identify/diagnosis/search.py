"""The search for what is missing: one effect, or two together.

Screening: which two or three effects together explain most of what a model leaves, by equation error.

Effects may hide each other, so that none looks good alone. Along the measured motion each is a column, and all pairs of
columns cost no more than a few milliseconds, all triples a tenth of a second; only the best are worth a fit.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from identify.arrays import Array
from identify.diagnosis.ranking import DENIED, at_rest
from identify.diagnosis.suspects import Candidate, candidate_terms, residual_lines, try_terms
from identify.effects.effect import Effect, Scales
from identify.effects.library import LIBRARY
from identify.fitting.baseline import Baseline
from identify.fitting.initial_values import scales_of, term_starts
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay

_INDEPENDENT = 1e-6
"""Share of a column that the model and the other column must leave free."""

_TIMES_LEAST = 4.0
"""Times as much as the best triple may leave of the restoring force."""

_THIRD_HELPS = 0.95
"""Share of what the best pair leaves that a triple must fall below."""


@dataclass(frozen=True, eq=False)
class Begun:
    """An effect with values of its inner parameters, by their own names, from which a fit may begin."""

    term: Term
    inner: dict[str, float]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


@dataclass(frozen=True, eq=False)
class _Columns:
    """Forces of unit strength along a motion, less what a model follows, of unit length.

    `begun` tells which effect each column is, with which inner parameters; `along` (columns,) is how much of what the model
    leaves lies along it, `overlap` (columns, columns) their products; `left` is the sum of squares that the model leaves.
    """

    begun: tuple[Begun, ...]
    along: Array
    overlap: Array
    left: float


def promising_pairs(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> tuple[tuple[str, str], ...]:
    """Return the pairs of effects by name, the one that leaves least of the restoring force first.

    Each effect is tried at all starting values of its inner parameters; strengths are free and of either sign.
    Faults of sensors are no forces, and are left out.
    """
    columns = _free_columns(prepared, model, terms, scales)
    if columns is None:
        return ()
    names = [begun.name for begun in columns.begun]
    explained = _explained_by_two(columns.along, columns.overlap)
    best: dict[tuple[str, str], float] = {}
    for i, j in combinations(range(len(names)), 2):
        if names[i] != names[j]:
            pair = (names[i], names[j]) if names[i] < names[j] else (names[j], names[i])
            best[pair] = max(best.get(pair, 0.0), float(explained[i, j]))
    return tuple(sorted(best, key=lambda pair: -best[pair]))


def promising_triples(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> tuple[tuple[Begun, Begun, Begun], ...]:
    """Return triples of effects with the inner parameters that leave least, the one that leaves least of all first.

    As pairs are; only those are returned that leave at most some times as much as the best, and none where even that leaves
    little less than the best pair: there a third effect has nothing to explain.
    """
    columns = _free_columns(prepared, model, terms, scales)
    if columns is None:
        return ()
    names = [begun.name for begun in columns.begun]
    first = [at for at, name in enumerate(names) if at == 0 or name != names[at - 1]]
    effect = np.repeat(np.arange(len(first)), np.diff([*first, len(names)]))
    apart = effect[:, None] != effect
    two = columns.left - _explained_by_two(columns.along, columns.overlap)
    found: dict[tuple[int, ...], tuple[float, tuple[int, int, int]]] = {}
    least = np.inf
    for i in range(len(effect)):
        beside, overlap = _less(columns.along, columns.overlap, i)
        left = columns.left - columns.along[i] ** 2 - _explained_by_two(beside, overlap)
        left[~apart | (effect == effect[i])[:, None] | (effect == effect[i])[None, :]] = np.inf
        left = np.maximum(left, 0.0)
        best = np.minimum.reduceat(np.minimum.reduceat(left, first, axis=0), first, axis=1)
        least = min(least, float(best.min()))
        for m, n in np.argwhere(np.triu(best <= _TIMES_LEAST * least, 1)):
            key = tuple(sorted((int(effect[i]), int(m), int(n))))
            if key not in found or best[m, n] < found[key][0]:
                j, k = np.argwhere((left == best[m, n]) & (effect == m)[:, None] & (effect == n))[0]
                found[key] = float(best[m, n]), (i, int(j), int(k))
    if not least < _THIRD_HELPS * float(two[apart].min(initial=np.inf)):
        return ()
    kept = sorted(entry for entry in found.values() if entry[0] <= _TIMES_LEAST * least)
    return tuple((columns.begun[i], columns.begun[j], columns.begun[k]) for _, (i, j, k) in kept)


def _less(along: Array, overlap: Array, i: int) -> tuple[Array, Array]:
    """Return columns (as in `_Columns`) less what they share with column i, of unit length again; 0 where that is all."""
    along = along - overlap[i] * along[i]
    overlap = overlap - np.outer(overlap[i], overlap[i])
    square = np.diag(overlap)
    over = np.where(square > _INDEPENDENT, 1.0 / np.sqrt(np.maximum(square, _INDEPENDENT)), 0.0)
    return along * over, overlap * np.outer(over, over)


def _free_columns(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> _Columns | None:
    begun, columns = _columns(prepared, terms, scales)
    if len(columns) < 2:
        return None
    used = moving(prepared.motion)
    _, known = _columns(prepared, model.forces, scales)
    basis = np.linalg.qr(np.column_stack([*known, np.ones(len(used))])[used])[0]
    design = _unit(np.column_stack(columns)[used])
    free = design - basis @ (basis.T @ design)
    size = np.linalg.norm(free, axis=0)
    free = np.where(size > _INDEPENDENT, free / np.maximum(size, _INDEPENDENT), 0.0)
    left = prepared.restoring[used] - basis @ (basis.T @ prepared.restoring[used])
    return _Columns(tuple(begun), free.T @ left, free.T @ free, float(left @ left))


def _columns(
    prepared: PreparedDecay, terms: tuple[Term, ...], scales: Scales
) -> tuple[list[Begun], list[Array]]:
    """Return the finite forces of unit strength along the motion, (n,) each, and which effects they are."""
    motion = prepared.motion
    begun, columns = [], []
    for term in (term for term in terms if term.is_force):
        for inner in term_starts(term, scales):
            along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
            force = force_along(term, inner, *along)
            if np.isfinite(force).all():
                begun.append(Begun(term, inner))
                columns.append(force)
    return begun, columns


def _unit(columns: Array) -> Array:
    return np.asarray(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))


def _explained_by_two(alone: Array, overlap: Array) -> Array:
    """Return the sum of squares that each two columns of unit length explain together, (columns, columns)."""
    apart = 1.0 - overlap**2
    both = alone[:, None] ** 2 + alone[None, :] ** 2 - 2.0 * overlap * np.outer(alone, alone)
    return np.where(apart > _INDEPENDENT, both / np.maximum(apart, _INDEPENDENT), 0.0)


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
    what goes best with the best single candidates follows, faults of sensors among them. The first
    plausible pair that reaches the floor ends the search, and is the only one.
    """
    found: list[Pair] = []
    best = _distinct(tried)[0] if tried else None
    for stage in (_screened, _greedy):
        for first, terms in stage(baseline, tried, library):
            polished = _POLISHED_BESIDE_BEST if first is best else _POLISHED_SECONDS
            goal = baseline.highest * first.fit.degrees
            seconds = try_terms(baseline.decays, first.fit, terms, polished=polished, goal=goal)
            rests = [at_rest(baseline.decays, candidate) for candidate in seconds]
            allowed = [
                (c.score - 2.0 * nats, c) for c, nats in zip(seconds, rests, strict=True) if nats > DENIED
            ]
            if not allowed:
                continue
            pair = Pair(first, min(allowed, key=lambda one: one[0])[1])
            if pair.plausible and baseline.adequate(pair.second.fit):
                return (pair,)
            found.append(pair)
    return tuple(sorted(found, key=lambda pair: (not pair.plausible, pair.second.score)))


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
