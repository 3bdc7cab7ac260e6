"""Output-error least squares: the parameters for which the simulated motion follows the readings best."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from identify.arrays import Array, Mask
from identify.clock_error import with_clock
from identify.effects.force_effect import LinearPart
from identify.estimate import Estimate
from identify.fitting.block_jacobian import BlockJacobian
from identify.fitting.jacobian import linearise
from identify.fitting.levenberg_marquardt import Minimum, minimise, minimise_fully, sum_of_squares
from identify.fitting.own_linear import centred, weighed
from identify.fitting.parameter_layout import Unknown
from identify.fitting.problem import Problem
from identify.model.model import Model, Term
from identify.model.parameter_id import nuisance
from identify.preprocessing.fit_window import FitWindow

_GROWTH = (3.0, 8.0, 20.0, 50.0, 120.0)
FAR_OFF = 30.0
"""Reduced chi-square from which on a model is far from the readings: its motion need not be followed to the noise."""

_ROUNDS = 3
"""How often the priors of single releases are scaled to the residual again, and all is fitted again."""

_COLLINEAR = 1e-13
"""Eigenvalue of the unknowns' scaled normal equations below which rounding hides what the readings say of them."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A model fitted to one or more windows.

    `values` holds every unknown by its name with its standard error; `chi_square` the sum of squares in units of the
    noise, `degrees` its degrees of freedom. `predicted` are the readings the model gives, a dictionary a window.
    `converged` says that no step was predicted to gain anything any more; `unidentifiable` names parameters that this
    record does not determine. `theta` and `covariance` belong to `unknowns`.
    """

    model: Model
    windows: tuple[FitWindow, ...]
    unknowns: tuple[Unknown, ...]
    theta: Array
    covariance: Array
    values: dict[str, Estimate]
    chi_square: float
    degrees: int
    predicted: tuple[dict[str, Array], ...]
    converged: bool
    unidentifiable: tuple[str, ...]
    frequency: float

    @property
    def reduced(self) -> float:
        """Reduced chi-square: 1 means that the residual is noise."""
        return self.chi_square / max(self.degrees, 1)

    @property
    def outcome(self) -> str:
        """What was reached, or what to do next, in words."""
        settled = (
            "The fit settled." if self.converged else "The fit did not settle; try other starting values."
        )
        lost = ", ".join(self.unidentifiable)
        return f"{settled} This record does not determine {lost}." if lost else settled

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the unknowns."""
        return tuple(unknown.name for unknown in self.unknowns)

    @property
    def point(self) -> dict[str, float]:
        """The unknowns by name, as starting values of another fit."""
        return dict(zip(self.names, self.theta.tolist(), strict=True))

    @property
    def parameters(self) -> dict[str, Estimate]:
        """The parameters of the effects by name: physics, and faults of sensors."""
        return {u.name: self.values[u.name] for u in self.unknowns if u.id.role == "parameter"}

    @property
    def nuisances(self) -> dict[str, Estimate]:
        """The releases' own unknowns by name: states at the start, lag, gain, offsets."""
        return {u.name: self.values[u.name] for u in self.unknowns if u.id.role != "parameter"}

    def of(self, term: Term, release: int | None = None) -> dict[str, Estimate]:
        """Return the parameters of one term by their own names: in one release, or in all ("limit[0]", "limit[1]")."""
        own = [u for u in self.unknowns if u.id.effect == term.effect.name and u.id.role == "parameter"]
        if release is None:
            return {u.id.in_effect: self.values[u.name] for u in own}
        return {u.id.parameter: self.values[u.name] for u in own if self._is_in(u, release)}

    def _is_in(self, unknown: Unknown, place: int) -> bool:
        """Check whether a window has an unknown, which it may share with others."""
        if unknown.whole_release:
            return self.windows[unknown.window].release == self.windows[place].release
        return unknown.window in (-1, place)

    def quoted(self, term: Term, release: int | None = None) -> dict[str, Estimate]:
        """Return the parameters of one term as `of` does, with those that are held: they are exact."""
        units = {parameter.name: parameter.unit for parameter in term.effect.parameters}
        held = {name: Estimate(value, 0.0, units[name]) for name, value in term.held_values.items()}
        return self.of(term, release) | held

    def nuisance(self, name: str, release: int) -> Estimate | None:
        """Return a nuisance of one release, such as its gain; None when it has none."""
        return self.values.get(str(nuisance(name, release, len(self.windows))))

    def of_release(self, release: int) -> dict[str, float]:
        """Return the values of one window and its physics, by their names in a fit of this window alone.

        The physics includes the deviations of the window's release.
        """
        found = self.of_windows((release,))
        for u in self.unknowns:
            own = str(u.id.of_release(0, 1))
            if u.deviates >= 0 and own in found:
                shared = self.unknowns[u.deviates]
                found[shared.name] = max(found[shared.name] + found.pop(own), shared.low)
        return found

    def of_windows(self, places: Sequence[int]) -> dict[str, float]:
        """Return the values of the physics and of some windows, by their names in a fit of these windows alone."""
        releases = list(dict.fromkeys(self.windows[i].release for i in places))
        found = {}
        for u, value in zip(self.unknowns, self.theta.tolist(), strict=True):
            if u.window < 0:
                found[u.name] = value
            elif u.whole_release:
                release = self.windows[u.window].release
                if release in releases:
                    found[str(u.id.of_release(releases.index(release), len(releases)))] = value
            elif u.window in places:
                found[str(u.id.of_release(places.index(u.window), len(places)))] = value
        return found

    def linear_strength(self, part: LinearPart) -> float | None:
        """Return the strength of the model's linear stiffness, damping or dry friction; None where it has none."""
        strength = self.model.linear_strength(part)
        return None if strength is None else self.values[str(strength)].value

    def residual(self, channel: str, i: int = 0) -> Array:
        """Return reading less prediction, SI, shape (n,), of one channel of window i."""
        return self.windows[i].readings[channel] - self.predicted[i][channel]

    def left(self, channel: str, i: int = 0) -> Array:
        """Return the residual about its mean: a zero that wanders, as coloured noise lets it, is no motion."""
        residual = self.residual(channel, i)
        return residual - np.mean(residual[self.windows[i].used[channel]])

    def in_noise(self, channel: str, i: int = 0) -> Array:
        """Return the residual of one channel of window i in units of its noise, whitened, 0 where not used, shape (n,)."""
        window = self.windows[i]
        return np.where(window.used[channel], window.in_noise(channel, self.residual(channel, i)), 0.0)

    def noise(self, channel: str, i: int = 0) -> float:
        """Return the rms of one channel's noise in window i; of coloured noise as much as in this residual."""
        window = self.windows[i]
        if channel not in window.colour:
            return float(window.sigma[channel])
        left, in_noise = self.left(channel, i)[window.used[channel]], self.in_noise(channel, i)
        return float(np.sqrt(np.sum(left**2) / np.sum(in_noise**2)))

    @cached_property
    def problem(self) -> Problem:
        """The problem that was solved."""
        return Problem(self.model, self.windows, self.frequency)

    @cached_property
    def linearised(self) -> tuple[Array, BlockJacobian]:
        """Misfit (readings,) and exact Jacobian where the fit ended."""
        return linearise(self.problem, self.theta)


def fit(
    model: Model,
    windows: tuple[FitWindow, ...],
    start: dict[str, float],
    frequency: float,
    *,
    tolerance: float = 0.02,
    near: bool = False,
    goal: float = 0.0,
    held: Collection[str] = (),
) -> Fit:
    """Fit a model to windows from starting values by name (see `initial_values`); the window grows where it is needed.

    Far from the readings fewer of them are compared, and the motion is integrated in longer steps; in the end all are. A
    start that is `near`, from curves of the whole decay, is not lost again to its first few cycles. A fit that creeps
    towards a `goal` of chi-square above 0, or ends above it and far from the readings, is left as it is. Unknowns whose
    names are `held` stay where they start. What single releases have of their own counts in units of what is left, found
    in turn.
    """
    problem = Problem(model, windows, frequency)
    still = np.array([u.name in held for u in problem.unknowns], dtype=bool)
    lower = partial(minimise_fully, tolerance=tolerance, held=still, goal=goal)
    found = _fit(problem, start, lower, still, near=near, goal=goal)
    for _ in range(_ROUNDS):
        again = weighed(found.problem, found.theta)
        if again == found.windows:
            break
        found = _fit(Problem(model, again, frequency), found.point, lower, still, near=True, goal=goal)
    return found


def _fit(
    problem: Problem,
    start: dict[str, float],
    lower: Callable[[Problem, Array], Minimum],
    still: Mask,
    *,
    near: bool,
    goal: float,
) -> Fit:
    """Solve the fit with the windows' priors on single releases, if there are any.

    `lower` finds a minimum; unknowns that are `still` are held.
    """
    again = partial(Problem, problem.model, problem.windows, problem.frequency)
    theta = np.clip(problem.theta(start), problem.low, problem.high)
    first = problem.residuals(theta)
    if sum_of_squares(first) > FAR_OFF * len(first):
        far = again(far=True)
        rough = lower(far, theta if near else _grow(problem, theta, still))
        if not near and not rough.cost < sum_of_squares(far.residuals(theta)):  # lost to the first few cycles
            rough = lower(far, theta)
        theta, still_far = rough.theta, not rough.cost < FAR_OFF * len(first)
        problem = again(coarse=still_far)
        if still_far and 0.0 < goal < rough.cost:
            return fit_at(problem, theta)
    found = lower(problem, theta)
    jacobian = found.jacobian if found.exact else linearise(problem, found.theta, skip=still)[1]
    return _result(problem, found.theta, found.cost, jacobian, still, settled=found.settled)


def fit_at(problem: Problem, theta: Array) -> Fit:
    """Make the fit at some values, without a further step."""
    residual, jacobian = linearise(problem, theta)
    still = np.zeros(len(theta), dtype=bool)
    return _result(problem, theta, float(residual @ residual), jacobian, still, settled=False)


def _grow(whole: Problem, theta: Array, still: Mask) -> Array:
    """Fit the unknowns to the first few cycles, then to more and more."""
    windows, w = whole.windows, whole.frequency
    longest = max(len(s) for s in windows)
    for cycles in _GROWTH:
        samples = int(cycles * 2.0 * np.pi / w * windows[0].rate)
        if samples >= longest:
            break
        parts = tuple(s.part(slice(samples)) for s in windows)
        if not any(used.any() for part in parts for used in part.used.values()):
            continue
        short = Problem(whole.model, parts, w, far=True)
        theta = minimise(short, theta, steps=8, tolerance=1.0, held=still).theta
    return theta


def _result(
    problem: Problem,
    theta: Array,
    cost: float,
    jacobian: BlockJacobian,
    held: Mask,
    *,
    settled: bool,
) -> Fit:
    fixed = held | (theta <= problem.low) | (theta >= problem.high)
    normal = jacobian.normal()
    # The readings do not tell a shared part from the mean of its deviations, which `centred` takes as none.
    for shared, deviations in problem.deviations.items():
        normal[np.ix_(deviations, deviations)] += normal[shared, shared]
    normal[held], normal[:, held] = 0.0, 0.0
    own = np.sqrt(np.where(np.diag(normal) > 0.0, np.diag(normal), 1.0))
    values, vectors = np.linalg.eigh(normal / np.outer(own, own))
    inverse = 1.0 / np.maximum(values, 1e-3 * _COLLINEAR)
    covariance = (vectors * inverse) @ vectors.T / np.outer(own, own)
    lost = (vectors[:, values < _COLLINEAR] ** 2).sum(axis=1) > 0.5
    unidentifiable = tuple(
        u.name for u, gone, bound in zip(problem.unknowns, lost, fixed, strict=True) if gone and not bound
    )
    spread = np.zeros(len(theta))
    if problem.expected:
        theta, covariance, spread = centred(problem, theta, covariance)
    seen = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    std = np.where(lost | held, np.inf, np.hypot(seen, spread))
    window = problem.windows[0]
    return Fit(
        model=problem.model,
        windows=problem.windows,
        unknowns=problem.unknowns,
        theta=theta,
        covariance=covariance,
        values={
            u.name: with_clock(Estimate(float(t), float(s), u.unit), window.rate, window.rate_std)
            for u, t, s in zip(problem.unknowns, theta, std, strict=True)
        },
        chi_square=cost,
        degrees=len(jacobian) - int((~fixed).sum()),
        predicted=tuple(
            problem.read(theta, i, motion.response) for i, motion in enumerate(problem.motions(theta))
        ),
        converged=settled,
        unidentifiable=unidentifiable,
        frequency=problem.frequency,
    )
