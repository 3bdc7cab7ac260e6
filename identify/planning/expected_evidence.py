"""The evidence that an experiment is expected to give between hypotheses, before it is made.

Each hypothesis in turn is taken for the truth, its parameters drawn from what the records so far leave open, and the
record simulated. Every other hypothesis is then refitted to that record and, through the covariance of its parameters, to
the records so far; half of the misfit that it keeps beyond that of the truth, in units of the noise, is the evidence
against it (Chaloner and Verdinelli 1995; Foster et al. 2019). That covariance holds near the fit only, so what leads is
refitted anew, to the simulated record and to the records so far themselves.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.judging.nonparametric_force import NonparametricForce, coordinates
from identify.planning.experiment import Experiment, carried_over, signed_amplitude, window_of
from identify.planning.hypotheses import Hypothesis
from identify.planning.so_far import SoFar
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_DRAWS = 4
"""Draws, that of the fit itself among them, of which a rival is refitted to the records themselves."""

_LEAVE = 2.0
"""How many times more than in linear theory a draw may contradict the release that was fitted."""

_DRAWN_BACK = 6
_ROUNDS = 3
_PICARD = 3
_FLAT = 1e-12
_BEYOND = 1e6
"""Nats beyond which a linear step says no more than that a rival is refuted."""

_WIDEST, _HELD = 0.5, 1e-9
"""Shares of itself by which a parameter is drawn that the records so far do not determine, and one at its bound."""


@dataclass(frozen=True, eq=False)
class ExpectedEvidence:
    """The evidence expected of an experiment: `nats[i, j, d]` against hypothesis j where i is true, in draw d.

    (hypotheses, hypotheses, draws). It is nan on the diagonal and where the motion diverges. Until a pair is refitted it
    is also nan in all draws but the first, the fit itself. `refitted` are the pairs refitted to the records themselves,
    `carried` the hypotheses as the experiment has them, None where the motion diverges.
    """

    experiment: Experiment
    nats: Array
    carried: "tuple[Carried | None, ...]"
    refitted: frozenset[tuple[int, int]] = frozenset()


@dataclass(frozen=True, eq=False)
class Carried:
    """A hypothesis carried over to an experiment: where its fit begins, what the records so far say, what it predicts.

    `centre` are the unknowns of its `problem`, `precision` and `spread` what is known of them and a root of their
    covariance, `misfit` and `jacobian` are taken there. `shared` are the places of what belongs to all records, `factors`
    by how much the experiment changes these.
    """

    problem: Problem
    centre: Array
    precision: Array
    spread: Array
    misfit: Array
    jacobian: Array
    shared: list[int]
    factors: Array

    def left(self, target: Array) -> float:
        """Return the misfit that a refit in a few steps keeps of a record (n,), itself given as a misfit."""
        theta, misfit, jacobian = self.centre, self.misfit, self.jacobian
        cost = float(np.sum((misfit - target) ** 2))
        for _ in range(_ROUNDS):
            gradient = jacobian @ (misfit - target) + self.precision @ (theta - self.centre)
            step = _solve(jacobian @ jacobian.T + self.precision, gradient)
            moved = np.clip(theta - step, self.problem.low, self.problem.high)
            again, slope = linearise(self.problem, moved)
            off = moved - self.centre
            new = float(np.sum((again - target) ** 2) + off @ self.precision @ off)
            if not new < cost or not _sound(slope.blocks[0]):
                break
            theta, misfit, jacobian = moved, again, slope.blocks[0]
            gained, cost = cost - new, new
            if gained < 1.0:
                break
        return _kept(jacobian, self.precision, misfit - target, theta - self.centre)


def draw_parameters(one: Hypothesis, last: PreparedDecay, seed: int) -> Array:
    """Draw errors of the shared parameters of a hypothesis, (draws, shared); the first draw is zero.

    They follow the covariance of its fit. Far from the fit that covariance does not hold: a draw that contradicts the
    release of the fit is drawn back.
    """
    random = np.random.default_rng([2019, seed])
    drawn = np.zeros((_DRAWS, sum(u.window < 0 for u in one.fit.unknowns)))
    again = Experiment(signed_amplitude(last))
    window = _window(again, last, one)
    own = None if window is None or not one.has_law else _carried(again, last, one.fit, window)
    if own is None:
        return drawn
    of_the_record = np.delete(own.jacobian, own.shared, axis=0)
    nothing = np.zeros(len(of_the_record))
    for row in drawn[1:]:
        normal = random.standard_normal(len(own.centre))
        offset = own.spread @ normal
        allowed = _LEAVE * float(normal @ normal)
        for _ in range(_DRAWN_BACK):
            misfit = own.problem.residuals(np.clip(own.centre + offset, own.problem.low, own.problem.high))
            change = misfit - own.misfit
            if (
                np.isfinite(misfit).all()
                and _kept(of_the_record, np.diag(nothing), change, nothing) < allowed
            ):
                row[:] = offset[own.shared]
                break
            offset = 0.5 * offset
    return drawn


def expected_evidence(
    experiment: Experiment,
    last: PreparedDecay,
    hypotheses: Sequence[Hypothesis],
    *,
    pairs: Sequence[tuple[int, int]],
) -> ExpectedEvidence | None:
    """Estimate the evidence that an experiment gives between hypotheses; None where its motion diverges or soon stops.

    `last` is the largest release so far; `pairs` are places of a hypothesis that is true, at its fit, and of one to be
    refuted, which is refitted in a few steps.
    """
    window = _window(experiment, last, hypotheses[0])
    if window is None:
        return None
    carried = tuple(_carried(experiment, last, one.fit, window) for one in hypotheses)
    nats = np.full((len(hypotheses), len(hypotheses), _DRAWS), np.nan)
    for i in sorted({i for i, _ in pairs}):
        own = carried[i]
        if own is None:
            continue
        at_fit = next(_readings(own, hypotheses[i], np.zeros((1, len(own.shared)))))
        record = own.problem.residual_of(0, at_fit)
        for j in (j for one, j in pairs if one == i):
            rival = carried[j]
            if rival is not None:
                nats[i, j, 0] = np.clip(0.5 * rival.left(record), 0.0, _BEYOND)
    return ExpectedEvidence(experiment, nats, carried)


def refitted(
    expected: ExpectedEvidence,
    hypotheses: Sequence[Hypothesis],
    so_far: Sequence[SoFar],
    *,
    pairs: Sequence[tuple[int, int]],
    drawn: Sequence[Array],
) -> ExpectedEvidence:
    """Estimate the evidence again with some pairs refitted to the releases `so_far` and to the simulated one.

    Of few draws; the scatter is then that of what is not known and of what linear theory had wrong.
    """
    carried, nats = expected.carried, expected.nats.copy()
    for i in sorted({i for i, _ in pairs}):
        own, one = carried[i], hypotheses[i]
        if own is None:
            continue
        rivals = {j: rival for true, j in pairs if true == i and (rival := carried[j]) is not None}
        for draw, readings in enumerate(_readings(own, one, drawn[i])):
            price = so_far[i].costs_more(own.problem, own.centre, readings) if one.has_law else 0.0
            for j, rival in rivals.items():
                kept = so_far[j].costs_more(rival.problem, rival.centre, readings)
                nats[i, j, draw] = np.clip(0.5 * (kept - price), 0.0, _BEYOND)
    return replace(expected, nats=nats, refitted=expected.refitted | frozenset(pairs))


def _window(experiment: Experiment, last: PreparedDecay, first: Hypothesis) -> FitWindow | None:
    """Return the window that an experiment would be compared in, by the likeliest hypothesis.

    It ends at the amplitude down to which the motion of the `last` release is followed; None where the motion diverges, or
    reaches that within five cycles.
    """
    window = window_of(experiment, last, first.fit.windows[0])
    problem = Problem(first.fit.model, (window,), first.fit.frequency, coarse=True)
    theta = problem.theta(carried_over(experiment, last, first.fit)[0])
    motion = problem.respond(np.clip(theta, problem.low, problem.high), 0).displacement
    if not np.isfinite(motion).all() or not np.min(motion) < 0.0 < np.max(motion):
        return None
    cycle = 2.0 * np.pi / last.frequency
    smallest = np.max(np.abs(last.motion.displacement[-max(int(cycle * last.window.rate), 1) :]))
    large = np.flatnonzero(np.abs(motion) >= smallest)
    samples = int(large[-1] + 0.5 * cycle * window.rate) if len(large) else 0
    return None if samples < 5.0 * cycle * window.rate else window.part(slice(samples))


def _carried(experiment: Experiment, last: PreparedDecay, found: Fit, window: FitWindow) -> Carried | None:
    problem = Problem(found.model, (window,), found.frequency, coarse=True)
    values, factors = carried_over(experiment, last, found)
    theta = np.clip(problem.theta(values), problem.low, problem.high)
    misfit, slope = linearise(problem, theta)
    if not (np.isfinite(misfit).all() and _sound(slope.blocks[0])):
        return None
    at, factor = [problem.index[name] for name in factors], np.array(list(factors.values()))
    precision, spread = _known(problem, found, at, factor)
    return Carried(problem, theta, precision, spread, misfit, slope.blocks[0], at, factor)


def _known(problem: Problem, found: Fit, at: list[int], factor: Array) -> tuple[Array, Array]:
    """Return the precision of a problem's unknowns from the records so far, and a root of their covariance.

    (unknowns, unknowns) each. The shared ones are `at` places and changed by a `factor`. Of what belongs to the new
    record alone they say nothing; what was held stays there.
    """
    shared = [i for i, u in enumerate(found.unknowns) if u.window < 0]
    names = [found.unknowns[i].name for i in shared]
    covariance = found.covariance[np.ix_(shared, shared)] * np.outer(factor, factor)
    own = problem.sizes(problem.theta(found.point))[at]
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    loose = np.array([n in found.unidentifiable for n in names], dtype=bool)
    fixed = np.array([not np.isfinite(found.values[n].std) for n in names], dtype=bool) & ~loose
    widest = np.where(fixed, _HELD * own, np.where(loose, _WIDEST * own, np.inf))
    shrink = np.minimum(1.0, widest / np.maximum(std, 1e-300))
    covariance = covariance * np.outer(shrink, shrink)
    size = np.maximum(std * shrink, _HELD * own)
    values, vectors = np.linalg.eigh(covariance / np.outer(size, size))
    values = np.maximum(values, _FLAT)
    count = len(problem.unknowns)
    precision, spread = np.zeros((count, count)), np.zeros((count, count))
    precision[np.ix_(at, at)] = (vectors / values) @ vectors.T / np.outer(size, size)
    spread[np.ix_(at, range(len(at)))] = size[:, None] * vectors * np.sqrt(values)
    return precision, spread


def _readings(own: Carried, one: Hypothesis, drawn: Array) -> Iterator[dict[str, Array]]:
    """Simulate a hypothesis at each draw of its parameters; at its fit where the motion diverges.

    Of a law outside the library they are alike; a random walk is another one each time.
    """
    problem = own.problem
    centre = problem.read(own.centre, 0, problem.respond(own.centre, 0))
    for draw, offset in enumerate(drawn):
        theta = own.centre.copy()
        if one.has_law:
            theta[own.shared] += own.factors * offset
        theta = np.clip(theta, problem.low, problem.high)
        response = problem.respond(theta, 0)
        for _ in range(0 if one.has_law else _PICARD):
            u, v = response.displacement, response.velocity
            force = _beside(one, problem.windows[0].clock, u, v, problem.frequency, draw)
            response = problem.respond(theta, 0, extra=-force)
        readings = problem.read(theta, 0, response)
        yield readings if all(np.isfinite(values).all() for values in readings.values()) else centre


def _beside(one: Hypothesis, time: Array, u: Array, v: Array, w: float, draw: int) -> Array:
    """Return the force per unit mass that acts beside the fit of a hypothesis, along a motion, (n,)."""
    if isinstance(one.beside, NonparametricForce):  # beyond where it was seen it stays as it is
        first = one.beside.shapes[0]
        position, factor = coordinates(time, u, v)[first.coordinate]
        return np.asarray(np.interp(position, first.position, first.force) * factor / first.at)
    assert one.beside is not None
    steps = np.random.default_rng([2020, draw]).standard_normal((2, len(time)))
    stiffer, damped = np.cumsum(steps, axis=1) * np.sqrt(np.gradient(time))
    return np.asarray(one.beside.stiffness * stiffer * w**2 * u + one.beside.damping * damped * w * v)


def _kept(jacobian: Array, precision: Array, misfit: Array, off: Array) -> float:
    """Return the smallest sum of squares, prior included, to which a linear step reduces a misfit (n,)."""
    gradient = jacobian @ misfit + precision @ off
    best = _solve(jacobian @ jacobian.T + precision, gradient)
    return float(misfit @ misfit + off @ precision @ off - gradient @ best)


def _sound(jacobian: Array) -> bool:
    """Check that a Jacobian can be squared: that of a motion that nearly diverges cannot."""
    with np.errstate(over="ignore", invalid="ignore"):
        return bool(np.isfinite(jacobian @ jacobian.T).all())


def _solve(normal: Array, right: Array) -> Array:
    """Solve symmetric equations; unknowns that they do not determine become zero."""
    size = np.sqrt(np.maximum(np.diag(normal), 1e-300))
    values, vectors = np.linalg.eigh(normal / np.outer(size, size))
    inverse = np.where(values > _FLAT, 1.0 / np.maximum(values, _FLAT), 0.0)
    return np.asarray((vectors * inverse) @ (vectors.T @ (right / size)) / size)
