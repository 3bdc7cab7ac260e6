"""Suspects: every effect that the model lacks, refitted in turn."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import count
from typing import TypeVar

import numpy as np

from identify.arrays import Array, Mask
from identify.diagnosis.linear_gain import (
    LINEAR_UP_TO,
    Slope,
    Starts,
    likeliest,
    probes,
    states_of_term,
    with_fault,
)
from identify.effects.effect import Effect, Scales
from identify.effects.library import LIBRARY
from identify.effects.sensor_fault import SensorFault
from identify.evidence import evidence
from identify.fitting.baseline import Baseline
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.fit import FAR_OFF, Fit, fit, fit_at
from identify.fitting.initial_values import (
    initial_values,
    inner_values,
    regress_model,
    scales_of,
    term_starts,
)
from identify.fitting.jacobian import linearise, take_steps
from identify.fitting.levenberg_marquardt import minimise
from identify.fitting.problem import Problem
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.model.parameter_id import ParameterId, nuisance
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.spectrum import strongest_lines

_Found = TypeVar("_Found")

_LINES = 3
_STARTS = 3
"""Places from which the fit of a force begins."""

_BY_LINEAR_GAIN = 2
"""How many of them are those of the largest linear gains, where these are known; equation error gives the others."""

_PRESENT = 1e-5
"""Share of the acceleration that a force has where a fit begins by its linear gain: the readings move in proportion."""

_NO_DAMPING = 1e-9
"""Damping of the first step from there: one that is mostly spring or damper would not get far with more."""

_FIRST_STEPS = 5
_POLISHED = 14
_LEADERS = 3
_BEHIND = 2.0
"""Multiple of the best chi-square up to which every suspect is polished to the end: it may be a rival."""


_ASTRAY = 1.1
"""Multiple of chi-square without a term above which its first steps have led away, and it is begun from hardly there."""

_HARDLY = 1e-6
"""Share of the acceleration that a force has where it is hardly there."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect in its best variant, added to a model and refitted, with its evidence (nats) against the model.

    `plausible` is False where another effect is the better name for the same force; `claimed` says that it may be named.
    """

    term: Term
    fit: Fit
    evidence: float
    plausible: bool
    claimed: bool = False

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


def residual_lines(found: Fit) -> dict[str, tuple[tuple[float, float, float], ...]]:
    """Return the strongest lines of each channel's residual, over all windows: (Hz, amplitude, phase at the release)."""
    lines: dict[str, tuple[tuple[float, float, float], ...]] = {}
    for i, window in enumerate(found.windows):
        for channel in window.channels:
            residual = np.where(window.used[channel], found.residual(channel, i), 0.0)[window.lead :]
            time = window.time + window.lead / window.rate
            lines[channel] = lines.get(channel, ()) + strongest_lines(residual, window.rate, time, _LINES)
    return lines


def candidate_terms(model: Model, library: Iterable[Effect], window: FitWindow) -> tuple[Term, ...]:
    """Return every effect and variant that the model lacks and that the channels of a window can show.

    Faults that every fit allows for are judged by what it allowed for. Over the segments of a long release each has
    offsets of its own, which leave slow faults of a sensor nothing to explain.
    """
    terms = []
    for effect in library:
        if not effect.has_meaning_for(window.unit):
            continue
        if isinstance(effect, SensorFault) and (effect.corrected_in_every_fit or window.segment):
            continue
        for variant in effect.variants:
            channel = variant.get("channel")
            if channel is not None and channel not in window.readings:
                continue
            if any(t.effect.name == effect.name and t.channel == (channel or "") for t in model.terms):
                continue
            terms.append(Term(effect, variant))
    return tuple(terms)


def singles(
    baseline: Baseline,
    library: tuple[Effect, ...] = LIBRARY,
    counted: Callable[[int, int], None] = lambda done, whole: None,
) -> tuple[Candidate, ...]:
    """Return the model refitted with each effect it lacks, best first; `counted` is told how many fits are done."""
    terms = candidate_terms(baseline.fit.model, library, baseline.fit.windows[0])
    return try_terms(baseline.decays, baseline.fit, terms, by_gain=True, counted=counted)


def try_terms(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    terms: tuple[Term, ...],
    *,
    polished: int = _POLISHED,
    goal: float | None = None,
    by_gain: bool = False,
    counted: Callable[[int, int], None] = lambda done, whole: None,
) -> tuple[Candidate, ...]:
    """Refit the model with each term added; return the best variant of each effect, best first.

    From each start the term's inner parameters are held at first, so that all others can make room for it. The most
    promising ones, `polished` of them, are then fitted freely: the first few to the end, the others until they creep
    with twice the best of these still below. Where only a `goal` of chi-square
    counts, a fit that creeps towards it is left. Near the floor fits begin at the places of the largest linear gains, too,
    if `by_gain`. `counted` is told how many fits are done,
    and of how many at most.
    """
    scales = scales_of(decays[0], residual_lines(base))
    near = Slope.of(base) if base.reduced < LINEAR_UP_TO else None
    floor = 0.0 if goal is None else goal
    done, whole = count(1), len(terms) + min(polished, len(terms))

    def step(found: _Found) -> _Found:
        counted(next(done), whole)
        return found

    def places(term: Term) -> Starts:
        return likeliest(decays, near, term, scales) if by_gain and near is not None else ()

    tried_to_begin = [step(_begin(decays, base, near, term, scales, floor, places(term))) for term in terms]
    begun = sorted((b for b in tried_to_begin if b is not None), key=lambda beginning: beginning.cost)
    leaders = begun[: min(_LEADERS, polished)]
    tried = [step(_finish(base, beginning, scales, floor)) for beginning in leaders]
    best_cost = min((c.fit.chi_square for c in tried if c.plausible), default=0.0)
    enough = _BEHIND * best_cost if goal is None else goal
    tried += [step(_finish(base, beginning, scales, enough)) for beginning in begun[len(leaders) : polished]]
    tried += [_leave(base, near, beginning, scales) for beginning in begun[polished:]]
    best: dict[str, Candidate] = {}
    for candidate in tried:
        if candidate.name not in best or candidate.evidence > best[candidate.name].evidence:
            best[candidate.name] = candidate
    return tuple(sorted(best.values(), key=lambda candidate: -candidate.evidence))


@dataclass(frozen=True, eq=False)
class _Beginning:
    """A term after the first steps, with its inner parameters held."""

    term: Term
    problem: Problem
    theta: Array
    cost: float


def _from_slope(slope: Slope, problem: Problem, theta: Array, held: Mask) -> tuple[Array, BlockJacobian]:
    """Return the misfit of the model with one more effect, and its Jacobian, only the new columns taken anew."""
    known_at = slope.problem.index
    take_steps(problem, slope.problem)
    known = np.array([unknown.name in known_at for unknown in problem.unknowns])
    residual, jacobian = linearise(problem, theta, skip=known | held)
    for at, unknown in enumerate(problem.unknowns):
        if known[at]:
            before = slope.jacobian.of_unknown(known_at[unknown.name])
            for (_, row), (_, values) in zip(jacobian.of_unknown(at), before, strict=True):
                row[:] = values
    return residual, jacobian


def _begin(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    slope: Slope | None,
    term: Term,
    scales: Scales,
    goal: float,
    likely: Starts,
) -> _Beginning | None:
    model, coarse = base.model.plus(term), base.reduced > FAR_OFF
    problem = Problem(model, base.windows, base.frequency, coarse=coarse, far=slope is None)
    inner = np.array([_is_inner(u.id, term) for u in problem.unknowns])
    weak = slope if term.is_force and not _has_free_state(problem, term) else None
    best = None if weak is None else _begin_weakly(decays, base, weak, problem, term, likely, inner)
    begun_at = 0 if best is None else min(len(likely), _BY_LINEAR_GAIN)
    starts = _promising(decays, base, problem.model, term, term_starts(term, scales), _STARTS - begun_at)
    if weak is None:
        starts = _promising(decays, base, problem.model, term, likely[:_BY_LINEAR_GAIN], _STARTS) + starts
    for start in starts:
        theta = np.clip(problem.theta(start), problem.low, problem.high)
        begun = None if slope is None else _from_slope(slope, problem, theta, inner)
        found = minimise(
            problem, theta, steps=_FIRST_STEPS, tolerance=1.0, held=inner, begun=begun, goal=goal
        )
        if best is None or found.cost < best.cost:
            best = _Beginning(term, problem, found.theta, found.cost)
    if best is not None and best.cost <= _ASTRAY * base.chi_square:
        return best
    for theta in _from_base(decays, base, problem, term, scales):
        found = minimise(problem, theta, steps=_FIRST_STEPS, tolerance=1.0, held=inner, goal=goal)
        if best is None or found.cost < best.cost:
            best = _Beginning(term, problem, found.theta, found.cost)
    return best


def _has_free_state(problem: Problem, term: Term) -> bool:
    """Whether a force has a state at the start that is unknown and without bounds: a force of hardly any strength could be
    as large as any by it.
    """
    return any(
        u.id.role == "state" and u.id.effect == term.effect.name and np.isinf(u.high)
        for u in problem.unknowns
    )


def _begin_weakly(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    slope: Slope,
    problem: Problem,
    term: Term,
    likely: Starts,
    inner: Mask,
) -> _Beginning | None:
    """Return the best of what a force of hardly any strength grows to at its likeliest places; None where there are none.

    The first step is as long as the linear gain predicts: without damping, however alike it is to what the model has.
    """
    best: _Beginning | None = None
    for place in likely[:_BY_LINEAR_GAIN]:
        for point in probes(decays, base, problem, term, place, _PRESENT)[:1]:
            theta = np.clip(point, problem.low, problem.high)
            begun = _from_slope(slope, problem, theta, inner)
            found = minimise(problem, theta, steps=_FIRST_STEPS, held=inner, begun=begun, damping=_NO_DAMPING)
            if best is None or found.cost < best.cost:
                best = _Beginning(term, problem, found.theta, found.cost)
    return best


def _from_base(
    decays: tuple[PreparedDecay, ...], base: Fit, problem: Problem, term: Term, scales: Scales
) -> list[Array]:
    """Return points at which a force is hardly there and all else is as without it: no model need lose to its own part.

    The equation error may give a start from which a force lets the motion run away.
    """
    if not term.is_force:
        return []
    points = [
        np.clip(point, problem.low, problem.high)
        for start in term_starts(term, scales)[:_STARTS]
        for point in probes(decays, base, problem, term, start, _HARDLY)[:1]
    ]
    return [point for point in points if np.isfinite(problem.residuals(point)).all()]


def _finish(base: Fit, begun: _Beginning, scales: Scales, goal: float) -> Candidate:
    start = {u.name: float(t) for u, t in zip(begun.problem.unknowns, begun.theta, strict=True)}
    near = begun.cost <= base.chi_square
    found = fit(begun.problem.model, base.windows, start, base.frequency, near=near, goal=goal)
    return score_candidate(found, base, begun.term, scales)


def _leave(base: Fit, near: Slope | None, begun: _Beginning, scales: Scales) -> Candidate:
    problem, slope = begun.problem, None
    if near is not None:
        slope = _from_slope(near, problem, begun.theta, np.zeros(len(begun.theta), dtype=bool))
    elif problem.windows is not base.windows:
        problem = Problem(problem.model, base.windows, base.frequency, coarse=True)
    return score_candidate(fit_at(problem, begun.theta, slope), base, begun.term, scales)


def _is_inner(unknown: ParameterId, term: Term) -> bool:
    own = unknown.effect == term.effect.name and unknown.role == "parameter"
    return own and unknown.parameter in term.effect.inner


def score_candidate(found: Fit, base: Fit, term: Term, scales: Scales) -> Candidate:
    """Weigh a refit against the fit without the term."""
    return Candidate(term, found, evidence(base, found, scales), is_plausible(found, term, scales))


def is_plausible(found: Fit, term: Term, scales: Scales) -> bool:
    """Whether a fit gives a term values with which no other effect is the better name for what it explains."""
    values = {name: estimate.value for name, estimate in found.of(term, len(found.windows) - 1).items()}
    at_fault = replace(scales, peaks={term.channel: scales.peaks[term.channel]}) if term.channel else scales
    return term.effect.plausible(values, at_fault)


def _promising(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    model: Model,
    term: Term,
    starts: Starts,
    few: int,
) -> list[dict[str, float]]:
    """Return complete starting points: the base's values with the term added at the strength of the equation error.

    Where the base is far off, all values come from the equation error. The best `few` by equation error are kept.
    """
    if not term.is_force:
        return [_with_fault(base, term, start, scales_of(decays[0], {})) for start in starts]
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    strength = str(term.strength)
    place = [t.effect.name for t in model.forces].index(term.effect.name)
    physics = {name: estimate.value for name, estimate in base.parameters.items()}
    ranked: list[tuple[float, dict[str, float]]] = []
    for start in starts:
        inner = physics | term.by_name(start)
        regression = regress_model(largest, model, inner)
        possible = term.effect.strength.low <= regression.strengths[place] <= term.effect.strength.high
        ranked.append((regression.rss if possible else np.inf, inner))
    ranked.sort(key=lambda entry: entry[0])
    points = []
    for rss, inner in ranked[:few]:
        point = initial_values(decays, model, inner)
        if not np.isfinite(rss):
            point[strength] = 1e-3 * _one_percent(largest, term, inner)
        if base.reduced < LINEAR_UP_TO:
            point = inner | base.point | {strength: point[strength]} | states_of_term(base, term, inner)
        points.append(point)
    return points


def _with_fault(base: Fit, term: Term, start: dict[str, float], scales: Scales) -> dict[str, float]:
    """Return a fit's values with a sensor's fault, and the lag that it would have been taken for undone."""
    point, count = with_fault(base, term, start), len(base.windows)
    if term.fault.seems_lag is not None:
        early = term.fault.seems_lag(tuple(start.values()), scales)
        early *= -1.0 if term.channel == "acceleration" else 1.0
        lags = [str(nuisance("lag", i, count)) for i in range(count)]
        point |= {lag: point[lag] + early for lag in lags if lag in point}
    return point


def _one_percent(prepared: PreparedDecay, term: Term, inner: dict[str, float]) -> float:
    """Return the strength at which an effect's rms force is a hundredth of the total."""
    motion = prepared.motion
    along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
    force = force_along(term, inner_values(term, inner), *along)
    size = float(np.sqrt(np.mean(force**2)))
    return 0.01 * float(np.sqrt(np.mean(motion.acceleration**2))) / size if size > 0.0 else 0.0
