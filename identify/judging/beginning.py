"""The first steps of a fit with one more effect: from the starts that promise most, its inner parameters held."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.effects.effect import Scales
from identify.fitting.fit import FAR_OFF, Fit
from identify.fitting.initial_values import (
    close_starts,
    initial_nuisances,
    initial_values,
    regress_model,
    regress_states,
    scales_of,
    term_starts,
)
from identify.fitting.levenberg_marquardt import minimise
from identify.fitting.problem import Problem
from identify.judging.linear_gain import (
    Slope,
    Starts,
    in_releases,
    is_near,
    likeliest,
    number_of,
    probes,
    states_of_term,
    weak_strength,
    with_fault,
)
from identify.model.model import Term
from identify.model.parameter_id import nuisance, values_in_release
from identify.preprocessing.equation_error import Regression
from identify.preprocessing.prepared_decay import PreparedDecay

_STARTS = 3
"""Places from which the fit of a force begins."""

_BY_LINEAR_GAIN = 2
"""How many of them are those of the largest linear gains, where these are known; equation error gives the others."""

_DAMPING, _NO_DAMPING = 1e-3, 1e-9
"""Damping of the first step, and of that of a force that is hardly there: one that is mostly spring or damper would not get
far with more."""

_FIRST_STEPS = 5

_ASTRAY = 1.1
"""Multiple of chi-square without a term above which its first steps have led away, and it is begun from hardly there."""


@dataclass(frozen=True, eq=False)
class Beginning:
    """A term after the first steps of its fit."""

    term: Term
    problem: Problem
    theta: Array
    cost: float


def begin(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    slope: Slope | None,
    term: Term,
    scales: Scales,
    goal: float,
) -> tuple[Beginning, ...]:
    """Take the first steps of a fit from a few starts and keep the best; none where a fault has no start.

    With a `slope` a force begins very weak at the places of its largest linear gains, where it grows as far as these
    predict; then at the strengths of the equation error. Where both make the fit worse it begins very weak
    from all starts: no model need be worse than a part of itself. Of one whose memory need not have begun at rest the best
    of such starts is kept, too: its first steps are taken with all parameters free, for held they drive its strength to
    none, or from very weak at the places of the largest linear gains, however far the fit is.
    """
    model, coarse = base.model.plus(term), base.reduced > FAR_OFF
    problem = Problem(model, base.windows, base.frequency, coarse=coarse, far=not is_near(base))
    effect = term.effect
    held = np.array([u.id.effect == effect.name and u.id.parameter in effect.inner for u in problem.unknowns])

    def best_of(points: list[Array], damping: float, *, held: Mask | None = held) -> list[Beginning]:
        found = []
        for point in points:
            theta = np.clip(point, problem.low, problem.high)
            end = minimise(
                problem, theta, steps=_FIRST_STEPS, tolerance=1.0, held=held, goal=goal, damping=damping
            )
            found.append(Beginning(term, problem, end.theta, end.cost))
        return sorted((one for one in found if np.isfinite(one.cost)), key=lambda one: one.cost)[:1]

    def hardly_there(places: Starts) -> list[Array]:
        return [p for place in places for p in probes(decays, base, problem, term, place)[:1]]

    starts, free = term_starts(term, scales), _has_free_state(problem, term)
    slope = Slope.of(base) if free and slope is None else slope
    likely = () if slope is None else likeliest(decays, slope, term, scales)[:_BY_LINEAR_GAIN]
    from_elsewhere: list[Beginning] = []
    if free:  # of hardly any strength it could be as large as any by its state
        points = _promising(decays, base, problem, term, likely, _STARTS)
        found = best_of(points + _promising(decays, base, problem, term, starts, _STARTS), _DAMPING)
        places = _not_from_rest(decays, base, problem, term, close_starts(term, scales))
        ends = best_of(places, _DAMPING, held=None) + best_of(hardly_there(likely), _NO_DAMPING)
        from_elsewhere = sorted(ends, key=lambda one: one.cost)[:1]
    else:
        found = best_of(hardly_there(likely), _NO_DAMPING)
        points = _promising(decays, base, problem, term, starts, _STARTS - len(likely))
        found += best_of(points, _DAMPING)
    if term.is_force and not any(one.cost <= _ASTRAY * base.chi_square for one in found):
        found += best_of(hardly_there(starts[:_STARTS]), _NO_DAMPING)
    return (*sorted(found, key=lambda one: one.cost)[:1], *from_elsewhere)


def _has_free_state(problem: Problem, term: Term) -> bool:
    """Check whether a force has a state at the start that is unknown and without bounds."""
    return any(
        u.id.role == "state" and u.id.effect == term.effect.name and np.isinf(u.high)
        for u in problem.unknowns
    )


def _promising(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    problem: Problem,
    term: Term,
    starts: Starts,
    few: int,
) -> list[Array]:
    """List complete starting points: the base's values with the term added at the strength of the equation error.

    Where the base is far off, all values come from the equation error. The best `few` by equation error are kept.
    """
    if not term.is_force:
        return [problem.theta(_with_fault(base, term, start, scales_of(decays[0], {}))) for start in starts]
    model, strength = problem.model, str(term.strength)
    largest = _largest(decays)
    points = []
    for rss, _, inner in _ranked(
        decays, base, problem, term, starts, lambda inner: regress_model(largest, model, inner)
    )[:few]:
        point = initial_values(decays, model, inner)
        if not np.isfinite(rss):
            own = values_in_release(inner, number_of(decays, largest))
            point[strength] = weak_strength(largest, term, own) or 0.0
        if is_near(base):
            point = inner | base.point | {strength: point[strength]} | states_of_term(base, term, inner)
        points.append(problem.theta(point))
    return points


def _not_from_rest(
    decays: tuple[PreparedDecay, ...], base: Fit, problem: Problem, term: Term, starts: Starts
) -> list[Array]:
    """List complete starting points at which the memory of a force did not begin at rest, the best by equation error.

    Strengths and states are those of the equation error. None where the largest release was recorded from rest.
    """
    model, largest = problem.model, _largest(decays)
    if largest.window.pre_release is not None:
        return []
    points = []
    ranked = _ranked(
        decays, base, problem, term, starts, lambda inner: regress_states(largest, model, inner, term)[0]
    )
    for rss, strengths, inner in ranked[:_STARTS]:
        if not np.isfinite(rss):
            break
        values = inner | {
            str(force.strength): value for force, value in zip(model.forces, strengths, strict=False)
        }
        point = initial_nuisances(decays, model, values) | values
        for i, decay in enumerate(decays):
            own = values_in_release(values, number_of(decays, decay))
            for j, off in enumerate(regress_states(decay, model, own, term)[1].tolist()):
                name = str(term.state(j).of_release(i, len(decays)))
                point[name] = point.get(name, 0.0) + off
        points.append(problem.theta(point))
    return points


def _largest(decays: tuple[PreparedDecay, ...]) -> PreparedDecay:
    return max(decays, key=lambda prepared: prepared.amplitude)


def _ranked(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    problem: Problem,
    term: Term,
    starts: Starts,
    regressed: Callable[[dict[str, float]], Regression],
) -> list[tuple[float, list[float], dict[str, float]]]:
    """Rank the starts of a force by equation error: what is left, the strengths, and the parameters, by unknown's name.

    They are `regressed` from the parameters in the largest release.

    What is left is infinite where the force would have an impossible strength.
    """
    largest = number_of(decays, _largest(decays))
    place, strength = problem.model.forces.index(term), term.effect.strength
    physics = {name: estimate.value for name, estimate in base.parameters.items()}
    ranked = []
    for start in starts:
        inner = physics | in_releases(base, term, start)
        found = regressed(values_in_release(inner, largest))
        possible = strength.low <= found.strengths[place] <= strength.high
        ranked.append((found.rss if possible else np.inf, found.strengths.tolist(), inner))
    return sorted(ranked, key=lambda entry: entry[0])


def _with_fault(base: Fit, term: Term, start: dict[str, float], scales: Scales) -> dict[str, float]:
    """Add a sensor's fault to a fit's values, and undo the lag that the fit mistook it for."""
    point, count = with_fault(base, term, start), len(base.windows)
    if term.fault.seems_lag is not None:
        early = term.fault.seems_lag(tuple(start.values()), scales)
        early *= -1.0 if term.channel == "acceleration" else 1.0
        lags = [str(nuisance("lag", i, count)) for i in range(count)]
        point |= {lag: point[lag] + early for lag in lags if lag in point}
    return point
