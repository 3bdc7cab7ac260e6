"""The model whose exact decay, seen through the transform, is the measured ridge: least squares, by Levenberg-Marquardt."""

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.signal.averaging import backbone_factors, envelope_factors, integrate_envelope
from identify.signal.covariance import misfit_covariance
from identify.wavelet.envelope import fit_phase, phase_model, solve_integrated
from identify.wavelet.ridge import STEPS_PER_CYCLE, Observed, RunsAway, exact_decay, values_of

Orders = tuple[int, tuple[int, ...]]
"""The order of damping and those of stiffness."""

_ROUNDS = 40
_TRIALS = 12
_HALVINGS = 4
_SETTLED = 0.01
"""Gain of chi-square, every point counted, below which nothing changes."""

_STEP = 1e-5
"""Step of differentiation, in sizes of a parameter: so short that friction seldom turns round in between."""

_JUMP = 20.0
"""Change of a reading by such a step, in steps of the motion's size, that is none of the motion."""

_STEPS_FOR_SLOPE = 50  # to a cycle
_SINGULAR = 1e-12


@dataclass(frozen=True, eq=False)
class RidgeFit:
    """A model of the ridge: `theta` (p,) is k(0), c_0..c_n of k' = -sum c_i k^i, then phi(0), w_1, ... of the odd `orders`.

    At the points, (m,): `averaged` is the envelope (m) by that equation, `envelope` and `phase` (rad) are those measured,
    freed of what the transform adds. `misfits` are the mean squares of what the exact decay leaves of each, in units of
    their noise; `spread` (p,) are the standard errors.
    """

    theta: Array
    orders: tuple[int, ...]
    averaged: Array
    envelope: Array
    phase: Array
    misfits: tuple[float, float]
    spread: Array

    @property
    def order(self) -> int:
        """The damping order."""
        return len(self.theta) - len(self.orders) - 3

    @property
    def slopes(self) -> Array:
        """What the backbone w = w_1 + w_3 k^2 + ... consists of, (orders,)."""
        return self.theta[-len(self.orders) :]

    @property
    def values(self) -> tuple[dict[int, float], Array]:
        """The stiffness k_i by its order i, and the damping mu_0, ..., per unit mass."""
        return values_of(self.theta, self.orders)

    @property
    def errors(self) -> tuple[Array, Array]:
        """The standard errors of both."""
        w, cut = self.slopes[0], self.order + 2
        of_stiffness = 2 * w * self.spread[cut + 1 :] / backbone_factors(self.orders)
        return of_stiffness, self.spread[1:cut] / envelope_factors(w, self.order)

    @property
    def misfit(self) -> float:
        """The mean square of what is left of envelope and phase together."""
        return sum(self.misfits) / 2.0

    @property
    def mse_percent(self) -> float:
        """The misfit of the envelope over its variance, as in eq. (18)."""
        return float(100 * np.mean((self.envelope - self.averaged) ** 2) / (np.var(self.envelope) + 1e-300))


def fit_exactly(
    observed: Observed, order: int, orders: tuple[int, ...], envelope: Array, phase: Array
) -> RidgeFit | None:
    """Fit damping up to `order` and stiffness of the odd `orders`, from where the averaged equations put them.

    `envelope` and `phase` (m,) for these are those measured, or freed of what the transform adds to a model nearby. None
    where the motion of that start diverges, even with an eighth of what the spring is beyond linear.
    """
    ridge, step = _Ridge(observed, orders, order), observed.step
    decay = solve_integrated(envelope, step, order, observed.weight)
    phases = fit_phase(phase, np.abs(envelope), step, orders, observed.weight)
    start = np.concatenate([decay, phases])
    starts = start * 0.5 ** np.outer(np.arange(_HALVINGS), np.arange(len(start)) > order + 3)
    begun = next((one for one in starts if np.isfinite(ridge.decays(one[None])).all()), None)
    if begun is None:
        return None
    theta, left, gain = _minimise(ridge, begun)
    averaged = integrate_envelope(theta[0], theta[1 : order + 2], step, len(envelope))
    turned = phase_model(theta[order + 2 :], averaged, step, orders)
    [seen], [seen_phase] = ridge.seen(ridge.decays(theta[None]))
    measured, measured_phase, _ = observed.measured
    freed, freed_phase = measured - (seen - averaged), measured_phase - (seen_phase - turned)
    of_envelope, of_phase = np.mean(left.reshape(2, -1) ** 2, axis=1)
    misfits, spread = (float(of_envelope), float(of_phase)), _spread(observed, left, gain)
    return RidgeFit(theta, orders, averaged, freed, freed_phase, misfits, spread)


class _Ridge:
    """What models with damping up to `order` and stiffness of these `orders` leave of a ridge."""

    def __init__(self, observed: Observed, orders: tuple[int, ...], order: int) -> None:
        self.observed, self.orders = observed, orders
        start, duration = float(np.max(observed.measured[0])), len(observed.samples) / observed.rate
        damping = [start / duration / start**i for i in range(order + 1)]
        stiffness = [1.0 / duration / start ** (i - 1) for i in orders]
        self.size = np.array([start, *damping, 1.0, *stiffness])
        """How far each parameter may go before the decay looks different, (p,)."""

    def decays(self, thetas: Array, steps: int = STEPS_PER_CYCLE) -> Array:
        """Return what the channel would read of models (q, p), (q, n), in so many steps a cycle; nan where one runs away."""
        decays = np.full((len(thetas), len(self.observed.samples)), np.nan)
        for decay, theta in zip(decays, thetas, strict=True):
            with suppress(RunsAway):
                decay[:] = exact_decay(self.observed, theta, self.orders, steps)
        return decays

    def seen(self, decays: Array) -> tuple[Array, Array]:
        """Return envelope and phase (q, m) that the transform shows of decays (q, n)."""
        envelope, phase, _ = self.observed.seen(decays.T)
        first = int(np.argmax(self.observed.weight > 0))  # where all begin alike, however far they part
        turns = np.round((phase - self.observed.measured[1])[:, first] / (2 * np.pi))
        return envelope, phase - 2 * np.pi * turns[:, None]

    def left(self, decays: Array) -> Array:
        """Return what decays (q, n) leave of both, (q, 2m), in units of their noise.

        A phase counts as far as there is an envelope, measured and computed: that of a mass at rest is rounding.
        """
        (envelope, phase), (measured, turned, _) = self.seen(decays), self.observed.measured
        off = (envelope - measured, (phase - turned) * np.minimum(envelope, measured))
        return np.concatenate([one * self.observed.inverse_noise for one in off], axis=1)

    def columns(self, theta: Array) -> Array:
        """Return how what a model leaves changes with its parameters, each in its size, (p, 2m).

        A reading that jumps by a small step stood next to a reversal of friction: it says nothing of a slope.
        """
        moves = np.vstack([np.zeros(len(theta)), np.diag(self.size)])
        here, *beside = self.decays(theta + _STEP * moves, _STEPS_FOR_SLOPE)
        change = np.array(beside) - here
        change[~(np.abs(change) < _JUMP * _STEP * np.ptp(here))] = 0.0
        before, *after = self.left(np.vstack([here, here + change]))
        return np.asarray((np.array(after) - before) / _STEP)


def _minimise(ridge: _Ridge, theta: Array) -> tuple[Array, Array, Array]:
    """Return the parameters (p,) that leave least, what they leave (2m,), and what carries noise into them, (p, 2m)."""
    [left], damping, gained = ridge.left(ridge.decays(theta[None])), 1e-3, np.inf
    for at in range(_ROUNDS):
        columns, cost = ridge.columns(theta), float(left @ left)
        normal, gradient = columns @ columns.T, columns @ left
        own = np.diag(np.diag(normal) + 1e-300)
        gain = np.linalg.solve(normal + _SINGULAR * own, columns)
        least = _SETTLED * (1.0 + cost / len(left))
        if min(gained, float(gradient @ (gain @ left))) < least or at == _ROUNDS - 1:
            break
        for _ in range(_TRIALS):
            trial = theta - np.linalg.solve(normal + damping * own, gradient) * ridge.size
            [beyond] = ridge.left(ridge.decays(trial[None]))
            gained = cost - float(beyond @ beyond)
            if gained > 0.0:
                theta, left, damping = trial, beyond, max(damping / 10.0, 1e-9)
                break
            damping *= 8.0
        else:
            break
    return theta, left, gain * ridge.size[:, None]


def _spread(observed: Observed, left: Array, gain: Array) -> Array:
    """Return the standard errors of the parameters, (p,).

    White noise of the samples carried through the transform, the misfit where there is one, and how far the fit is from
    settled. `left` (2m,) is what it leaves of envelope and phase, `gain` (p, 2m) carries that into the parameters.
    """
    count, on = len(observed.points), observed.weight > 0
    _, phase, _ = observed.measured
    turned = observed.inverse_noise * np.exp(1j * (phase + observed.derivatives * np.pi / 2))
    of_envelope, of_phase = gain[:, :count], gain[:, count:]
    on_points = (of_envelope + 1j * of_phase) * turned / observed.angular_frequency**observed.derivatives
    rows = observed.noise * observed.ridge.weights_on_samples(on_points, len(observed.samples))
    covariance = rows @ rows.T
    for part, carried in ((left[:count], of_envelope), (left[count:], of_phase)):
        covariance += misfit_covariance(part[on], carried[:, on], observed.independent, len(gain) // 2)
    return np.where(gain.any(axis=1), np.hypot(np.sqrt(np.diag(covariance)), gain @ left), np.inf)
