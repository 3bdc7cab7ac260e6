"""The linear gain: by how much one more effect would lower chi-square if the misfit were linear in its strength.

Near the truth a small force changes the prediction in proportion. There one simulation for each value of an
effect's inner parameters gives, before any fit, nearly the result of a fit: what the model's own parameters can follow of
the misfit, and of the change that the effect makes, is left out.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Scales
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.fit import Fit
from identify.fitting.initial_values import close_starts, inner_values, rest_states, term_starts
from identify.fitting.jacobian import linearise
from identify.fitting.model_error import motion_percent
from identify.fitting.problem import Problem
from identify.model.measured_path import force_along
from identify.model.model import Term
from identify.model.parameter_id import values_in_release
from identify.preprocessing.fit_window import release_numbers
from identify.preprocessing.prepared_decay import PreparedDecay


def states_of_term(base: Fit, term: Term, inner: dict[str, float]) -> dict[str, float]:
    """Return the internal states of one more effect, by unknown's name, at the starts of the releases of a fit."""
    if not term.force.states:
        return {}
    found: dict[str, float] = {}
    count = len(base.windows)
    for i in range(count):
        start = base.of_release(i)
        states = rest_states(term, start["displacement"], start["velocity"], inner)
        found |= {str(id.of_release(i, count)): value for id, value in states.items()}
    return found


def with_fault(base: Fit, term: Term, start: dict[str, float]) -> dict[str, float]:
    """Return a fit's values with a sensor's fault in every release.

    Of several, a line has a size and a phase of its own in each.
    """
    point, count = base.point, len(base.windows)
    for i in range(count):
        several = term.effect.line and count > 1
        own = _line_of_release(base, term, term.channel, start, i) if several else start
        point |= {str(term.parameter(name).of_release(i, count)): value for name, value in own.items()}
    return point


def in_releases(base: Fit, term: Term, start: dict[str, float], first: int = 0) -> dict[str, float]:
    """Return the values of a force in all releases, by unknown's name, from those in one window's, by their own.

    The phase of a line is ahead of the residual's by the same right angles in each.
    """
    values, (numbers, count) = term.by_name(start), release_numbers(base.windows)
    for phase in (p for p in term.free if p.of_release and count > 1):
        seen = [
            _line_of_release(base, term, window.channels[0], start, i)[phase.name]
            for i, window in enumerate(base.windows)
        ]
        quarters = np.rint((values.pop(str(term.parameter(phase.name))) - seen[first]) / (0.5 * np.pi))
        values |= {
            str(term.in_release(phase, number, count)): float((own + 0.5 * np.pi * quarters) % (2.0 * np.pi))
            for number, own in zip(numbers, seen, strict=True)
        }
    return values


def number_of(decays: tuple[PreparedDecay, ...], decay: PreparedDecay) -> int:
    """Return the number of the release, among those of some decays, that one of them belongs to."""
    return release_numbers([one.window for one in decays])[0][decays.index(decay)]


def _line_of_release(
    base: Fit, term: Term, channel: str, start: dict[str, float], i: int
) -> dict[str, float]:
    """Fit a line of the frequency of `start` to the residual of a channel of release i."""
    window = base.windows[i]
    units = {p.unit: p.name for p in term.effect.parameters}
    used = window.used[channel]
    angle = 2.0 * np.pi * start[units["Hz"]] * window.clock[used]
    waves = np.column_stack([np.sin(angle), np.cos(angle)])
    sine, cosine = np.linalg.lstsq(waves, base.residual(channel, i)[used], rcond=None)[0]
    own = {
        term.effect.strength.name: float(np.hypot(sine, cosine)),
        units["rad"]: float(np.arctan2(cosine, sine) % (2.0 * np.pi)),
    }
    return start | own


def probes(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    problem: Problem,
    term: Term,
    start: dict[str, float],
) -> list[Array]:
    """List points near a fit at which a force is weakly present, one for each of its linear freedoms.

    `problem` is that of the model with the term, `start` has its inner parameters by their own names.
    """
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    begun, count = in_releases(base, term, start), len(base.windows)
    inner = {name: estimate.value for name, estimate in base.parameters.items()} | begun
    strength = weak_strength(largest, term, values_in_release(inner, number_of(decays, largest)))
    if strength is None:
        return []
    states = states_of_term(base, term, inner)
    point = base.point | begun | {str(term.strength): strength} | states
    points = [point]
    sizes = term.force.state_sizes(largest.amplitude, largest.frequency)
    for i in range(count):
        for j in range(term.force.states):
            name = str(term.state(j).of_release(i, count))
            if name in states and name in problem.index:
                points.append(point | {name: states[name] + 0.5 * sizes[j]})
    return [problem.theta(p) for p in points]


def weak_strength(prepared: PreparedDecay, term: Term, inner: dict[str, float]) -> float | None:
    """Return a strength at which an effect is weak along a motion; None where it has no strength, or diverges."""
    motion = prepared.motion
    along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
    force = force_along(term, inner_values(term, inner), *along)
    with np.errstate(over="ignore", invalid="ignore"):  # what is too stiff for a measured motion diverges
        rms = float(np.sqrt(np.mean(force**2)))
    return _PRESENT * float(np.sqrt(np.mean(motion.acceleration**2))) / rms if 0.0 < rms < np.inf else None


_LINEAR_UP_TO = 100.0
"""Reduced chi-square up to which one more effect moves the readings in proportion; beyond, gains are far beyond chance."""

_IN_PHASE = 50.0
"""% of the motion that a fit leaves which has lost its phase, however large the noise: nothing of it is worth keeping."""

Starts = tuple[dict[str, float], ...]
"""Values of a term's inner parameters by their own names, one dictionary for each place from which a fit may begin."""

_PRESENT = 1e-5
"""Share of the acceleration that a weakly present force has: it moves the readings by a few units of noise."""

_FEWEST_PLACES, _MOST_NUMBERS = 100, 500_000
"""Places of one force among which the largest gain is sought, and numbers in its columns where there are more."""

_INDEPENDENT = 1e-6
"""Size of a direction, as a share of the largest, that counts as none."""


def is_near(base: Fit) -> bool:
    """Check that a fit is near enough to the readings for one more effect to move them in proportion."""
    return base.reduced < _LINEAR_UP_TO and motion_percent(base) < _IN_PHASE


@dataclass(frozen=True, eq=False)
class Slope:
    """How the misfit of a fit, the `base`, depends on its unknowns at a few readings a cycle: misfit (n,) and Jacobian."""

    base: Fit
    problem: Problem
    residual: Array
    jacobian: BlockJacobian

    @classmethod
    def of(cls, base: Fit) -> Self:
        """Return the slope at a fit."""
        windows = tuple(one.at_few_readings(base.frequency) for one in base.windows)
        problem = Problem(base.model, windows, base.frequency, coarse=True)
        return cls(base, problem, problem.residuals(base.theta), linearise(problem, base.theta)[1])


def likeliest(decays: tuple[PreparedDecay, ...], slope: Slope, term: Term, scales: Scales) -> Starts:
    """Find the local maxima of a force's linear gain, the largest first.

    A fault has none. For a line they are the residual's own lines.
    """
    starts = (term_starts if term.effect.line else close_starts)(term, scales)
    if not term.is_force or len(starts) < 2:
        return ()
    starts = starts[:: len(starts) // max(_FEWEST_PLACES, _MOST_NUMBERS // len(slope.residual)) + 1]
    gains = [0.0, *_gains(decays, slope, term, starts), 0.0]
    tops = [i for i in range(1, len(gains) - 1) if 0.0 < gains[i] >= max(gains[i - 1], gains[i + 1])]
    return tuple(starts[i - 1] for i in sorted(tops, key=lambda i: -gains[i]))


def promising_forces(
    decays: tuple[PreparedDecay, ...], base: Fit, terms: tuple[Term, ...], scales: Scales, count: int
) -> tuple[Term, ...]:
    """Select the few forces, among some terms, of the largest linear gains beside a fit, the largest first."""
    slope = Slope.of(base)
    gains = {
        term: max(_gains(decays, slope, term, term_starts(term, scales)), default=0.0)
        for term in terms
        if term.is_force
    }
    return tuple(sorted(gains, key=lambda term: -gains[term])[:count])


def _gains(decays: tuple[PreparedDecay, ...], slope: Slope, term: Term, starts: Starts) -> list[float]:
    """Return the linear gain of a force from each of some starts; 0 where its motion is not finite."""
    base, before = slope.base, slope.residual
    problem = Problem(base.model.plus(term), slope.problem.windows, base.frequency, coarse=True)
    misfit, gains = slope.jacobian.free(before), []
    for start in starts:
        moved = [problem.residuals(p) for p in probes(decays, base, problem, term, start)]
        known = bool(moved) and all(np.isfinite(one).all() for one in moved)
        columns = [moved[0] - before, *(one - moved[0] for one in moved[1:])] if known else []
        gains.append(_gain(misfit, slope.jacobian.free(np.column_stack(columns)), term) if columns else 0.0)
    return gains


def _gain(misfit: Array, columns: Array, term: Term) -> float:
    """Return the fall of chi-square with a force whose strength and states are free, each a column (n, columns)."""
    if columns.shape[1] == 1 and term.effect.one_sided and misfit @ columns[:, 0] > 0.0:
        return 0.0
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    kept = sizes > _INDEPENDENT * max(sizes, default=0.0)
    return float(np.sum((basis[:, kept].T @ misfit) ** 2))
