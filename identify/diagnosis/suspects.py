"""Suspects: every effect that the model lacks, refitted in turn."""

from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask
from identify.effects.effect import Effect, Scales
from identify.fitting.fit import Fit, fit, fit_at
from identify.fitting.initial_values import (
    initial_values,
    regress_model,
    rest_states,
    scales_of,
    term_starts,
)
from identify.fitting.levenberg_marquardt import minimise
from identify.fitting.problem import Problem
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.spectrum import strongest_lines

JUDGED_APART = ("channel_lag", "channel_gain", "dropouts")
"""Faults that are always fitted or taken out beforehand, and are judged from what was found then."""

_LINES = 3
_STARTS = 3
_FIRST_STEPS = 5
_POLISHED = 10
_FAR_OFF = 100.0
_IMPLAUSIBLE = 10.0


@dataclass(frozen=True, eq=False)
class Candidate:
    """One effect in its best variant, added to a model and refitted; `score` is chi-square with BIC's penalty."""

    term: Term
    fit: Fit
    score: float
    gain: float
    plausible: bool

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


def residual_lines(found: Fit) -> dict[str, tuple[tuple[float, float, float], ...]]:
    """Return the strongest lines of each channel's residual, over all spans: (Hz, amplitude, phase at the release)."""
    lines: dict[str, tuple[tuple[float, float, float], ...]] = {}
    for i, window in enumerate(found.windows):
        for channel in window.channels:
            residual = np.where(window.used[channel], found.residual(channel, i), 0.0)[window.lead :]
            time = window.time + window.lead / window.rate
            lines[channel] = lines.get(channel, ()) + strongest_lines(residual, window.rate, time, _LINES)
    return lines


def candidate_terms(model: Model, library: Iterable[Effect], window: FitWindow) -> tuple[Term, ...]:
    """Return every effect and variant that the model lacks and that the channels of a span can show.

    Over the episodes of a long release each has offsets of its own, which leaves slow faults of a sensor nothing to say.
    """
    terms = []
    for effect in library:
        if effect.name in JUDGED_APART or (window.segment and effect.kind == "sensor"):
            continue
        for variant in effect.variants:
            channel = variant.get("channel")
            if channel is not None and channel not in window.readings:
                continue
            if any(t.effect.name == effect.name and t.channel == (channel or "") for t in model.terms):
                continue
            terms.append(Term(effect, variant))
    return tuple(terms)


def try_terms(
    decays: tuple[PreparedDecay, ...], base: Fit, terms: tuple[Term, ...], *, polished: int = _POLISHED
) -> tuple[Candidate, ...]:
    """Refit the model with each term added; return the best variant of each effect, best first.

    From each start the term's inner parameters are held at first, so that all others can make room for it. The most
    promising ones, `polished` of them, are then fitted freely.
    """
    scales = scales_of(decays[0], residual_lines(base))
    slope = _slope(base)
    with ThreadPoolExecutor() as pool:
        begun = [
            b
            for b in pool.map(lambda term: _begin(decays, base, slope, term, scales), terms)
            if b is not None
        ]
        begun.sort(key=lambda beginning: beginning.cost)
        tried = list(pool.map(lambda beginning: _finish(base, beginning, scales), begun[:polished]))
        tried += [_leave(base, beginning, scales) for beginning in begun[polished:]]
    best: dict[str, Candidate] = {}
    for candidate in tried:
        if candidate.name not in best or candidate.score < best[candidate.name].score:
            best[candidate.name] = candidate
    return tuple(sorted(best.values(), key=lambda candidate: candidate.score))


def try_term(decays: tuple[PreparedDecay, ...], base: Fit, term: Term) -> Candidate | None:
    """Refit the model with one term added; None when it has nowhere to start."""
    scales = scales_of(decays[0], residual_lines(base))
    begun = _begin(decays, base, _slope(base), term, scales)
    return None if begun is None else _finish(base, begun, scales)


@dataclass(frozen=True, eq=False)
class _Beginning:
    """A term after the first steps, with its inner parameters held."""

    term: Term
    problem: Problem
    theta: Array
    cost: float


@dataclass(frozen=True, eq=False)
class _Slope:
    """How a model's misfit depends on its unknowns, from which the search for one more effect sets out."""

    problem: Problem
    jacobian: Array

    def begin(self, problem: Problem, theta: Array, held: Mask) -> tuple[Array, Array]:
        """Return the misfit of the model with one more effect, and its Jacobian, only the new columns taken anew."""
        problem.take_steps(self.problem)
        known = np.array([unknown.name in self.problem.index for unknown in problem.unknowns])
        residual, jacobian = problem.linearise(theta, skip=known | held)
        for at, unknown in enumerate(problem.unknowns):
            if known[at]:
                jacobian[:, at] = self.jacobian[:, self.problem.index[unknown.name]]
        return residual, jacobian


def _slope(base: Fit) -> _Slope | None:
    """Return the slope of a fitted model; None where it is so far off that another place is searched."""
    if base.reduced >= _FAR_OFF:
        return None
    problem = Problem(base.model, base.windows, base.frequency)
    return _Slope(problem, problem.linearise(base.theta)[1])


def _begin(
    decays: tuple[PreparedDecay, ...], base: Fit, slope: _Slope | None, term: Term, scales: Scales
) -> _Beginning | None:
    problem = Problem(base.model.plus(term), base.windows, base.frequency)
    inner = np.array([u.name.split("[")[0] in _inner_names(term) for u in problem.unknowns])
    best: _Beginning | None = None
    for start in _promising(decays, base, problem.model, term, term_starts(term, scales)):
        theta = np.array([start.get(u.name, 0.0) for u in problem.unknowns])
        theta = np.clip(theta, problem.low, problem.high)
        begun = None if slope is None else slope.begin(problem, theta, inner)
        found = minimise(problem, theta, steps=_FIRST_STEPS, tolerance=1.0, held=inner, begun=begun)
        if best is None or found.cost < best.cost:
            best = _Beginning(term, problem, found.theta, found.cost)
    return best


def _finish(base: Fit, begun: _Beginning, scales: Scales) -> Candidate:
    start = {u.name: float(t) for u, t in zip(begun.problem.unknowns, begun.theta, strict=True)}
    return judged(fit(begun.problem.model, base.windows, start, base.frequency), base, begun.term, scales)


def _leave(base: Fit, begun: _Beginning, scales: Scales) -> Candidate:
    return judged(fit_at(begun.problem, begun.theta), base, begun.term, scales)


def _inner_names(term: Term) -> set[str]:
    return {f"{term.effect.name}.{name}" for name in term.effect.inner}


def judged(found: Fit, base: Fit, term: Term, scales: Scales) -> Candidate:
    """Weigh a refit against the fit without the term."""
    extra = len(found.names) - len(base.names)
    score = found.chi_square + extra * float(np.log(found.degrees))
    by_name = {name.split("[")[0]: estimate.value for name, estimate in found.values.items()}
    values = {p.name: by_name[f"{term.effect.name}.{p.name}"] for p in term.free}
    at_fault = replace(scales, peaks={term.channel: scales.peaks[term.channel]}) if term.channel else scales
    plausible = term.effect.plausible(values, at_fault)
    if not plausible:
        score += _IMPLAUSIBLE
    return Candidate(term, found, score, base.chi_square - found.chi_square, plausible)


def _promising(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    model: Model,
    term: Term,
    starts: tuple[dict[str, float], ...],
) -> list[dict[str, float]]:
    """Return complete starting points: the base's values with the term added at the strength of the equation error.

    Where the base is far off, all values come from the equation error. The best few by equation error are kept.
    """
    known = dict(zip(base.names, base.theta.tolist(), strict=True))
    tags = [f"[{i}]" for i in range(len(decays))] if len(decays) > 1 else [""]
    if term.effect.kind == "sensor":
        scales = scales_of(decays[0], {})
        return [_with_fault(known, term, start, tags, scales) for start in starts]
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    strength = f"{term.effect.name}.{term.effect.strength.name}"
    place = [t.effect.name for t in model.terms if t.effect.kind == "physics"].index(term.effect.name)
    ranked: list[tuple[float, dict[str, float]]] = []
    for start in starts:
        inner = {n: v for n, v in known.items() if "." in n} | start
        regression = regress_model(largest, model, inner)
        possible = term.effect.strength.low <= regression.strengths[place] <= term.effect.strength.high
        ranked.append((regression.rss if possible else np.inf, inner))
    ranked.sort(key=lambda entry: entry[0])
    points = []
    for rss, inner in ranked[:_STARTS]:
        point = initial_values(decays, model, inner)
        if not np.isfinite(rss):
            point[strength] = 1e-3 * _one_percent(largest, term, inner)
        if base.reduced < _FAR_OFF:
            kept = known | {strength: point[strength]} | {n: v for n, v in inner.items() if n not in known}
            for tag in tags:
                states = rest_states(term, known[f"displacement{tag}"], known[f"velocity{tag}"], inner)
                kept |= {f"{name}{tag}": value for name, value in states.items()}
            point = kept
        points.append(point)
    return points


def _with_fault(
    known: dict[str, float], term: Term, start: dict[str, float], tags: list[str], scales: Scales
) -> dict[str, float]:
    """Return the base's values with a sensor's fault, and the lag that it would have been taken for undone."""
    point = known | {f"{n}{tag}": v for n, v in start.items() for tag in tags}
    if term.effect.seems_lag is not None:
        early = term.effect.seems_lag(tuple(start.values()), scales)
        early *= -1.0 if term.channel == "acceleration" else 1.0
        point |= {f"lag{tag}": known[f"lag{tag}"] + early for tag in tags if f"lag{tag}" in known}
    return point


def _one_percent(prepared: PreparedDecay, term: Term, inner: dict[str, float]) -> float:
    """Return the strength at which an effect's rms force is a hundredth of the total."""
    values = {p.name: inner[f"{term.effect.name}.{p.name}"] for p in term.free[1:]}
    shared = {"linear_stiffness.k": prepared.frequency**2}
    motion = prepared.motion
    force = force_along(term, values, prepared.time, motion.displacement, motion.velocity, shared)
    size = float(np.sqrt(np.mean(force**2)))
    return 0.01 * float(np.sqrt(np.mean(motion.acceleration**2))) / size if size > 0.0 else 0.0
