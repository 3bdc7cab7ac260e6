"""One channel's ridge, fitted: envelope and phase freed of the transform's own bias.

Averaging is first order in the damping, a window is one-sided at the ends of a record, and dry friction
shifts the displacement's phase. All three are the same for the measured decay and for a computed one with
nearly the same parameters. So the fitted model is integrated exactly, sent through the same transform, and
what the transform then shows beyond the averaged model is taken off the measurement; a few rounds suffice.
"""

from dataclasses import dataclass
from functools import cached_property
from math import ceil, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.effects.families import POWER_LAW_DAMPING
from identify.effects.library import DAMPING_BY_ORDER, STIFFNESS_BY_ORDER
from identify.errors import NotIdentifiable
from identify.model.simulate import Response, make_system, simulate
from identify.signal.averaging import backbone_factors, envelope_factors
from identify.signal.harmonic_windows import HarmonicWindows
from identify.wavelet.envelope import (
    EnvelopeFit,
    PhaseFit,
    fit_envelope,
    fit_phase,
    solve_integrated,
)

WIDTH_CYCLES = 1.0  # standard deviation of the window: the third harmonic is 12 of its bandwidths away
POINTS_PER_CYCLE = 8
_REACH = 4.0  # the window is cut at 4 standard deviations, where it is 3e-4
_MOST_POINTS = 400
_STEPS_PER_CYCLE = 200  # the frequency of a fourth-order step is then off by 1e-8
_RUN_AWAY = 100.0  # times the first amplitude: no free decay grows so far
_BAND = 3.0  # factor about the frequency of the ridge within which it sees anything


class RunsAway(NotIdentifiable):
    """The coefficients describe no free decay.

    The motion grows without end, is no number, leaves the ridge's band, or its dry friction holds it from the start.
    """

    def __init__(self) -> None:
        super().__init__(
            "with the stiffness and the damping of the envelope the motion would diverge; "
            "release from a smaller amplitude, or try lower orders"
        )


@dataclass(frozen=True, eq=False)
class Observed:
    """One channel of the window, ready for the ridge.

    `samples` (n,) are the channel's, `derivatives` 0, 1 or 2 says how often displacement was differentiated to give it,
    `noise` its white-noise standard deviation; `points` are the samples at which the ridge is
    fitted, `weight` (m,) and `variance` (m,) the weight and the variance of the envelope there.
    """

    samples: Array
    valid: Mask
    rate: float
    derivatives: int
    angular_frequency: float
    noise: float
    ridge: HarmonicWindows
    points: NDArray[np.int_]
    weight: Array
    variance: Array

    @property
    def step(self) -> float:
        """Time between two fitted points, s."""
        return float((self.points[1] - self.points[0]) / self.rate)

    @property
    def independent(self) -> float:
        """Number of independent points: the window's noise is correlated over 2 sqrt(pi) widths."""
        width = WIDTH_CYCLES * 2 * np.pi * self.rate / self.angular_frequency
        return float(len(self.samples) / (2 * np.sqrt(np.pi) * width) + 1)

    def seen(self, samples: Array) -> tuple[Array, Array, Array]:
        """Return displacement's envelope, phase (rad) and frequency (rad/s) at the points, shape (m,)."""
        p, q, _ = self.ridge(samples)
        envelope = np.abs(p) / self.angular_frequency**self.derivatives
        expected = self.angular_frequency * self.points / self.rate
        phase = np.unwrap(np.angle(p * np.exp(-1j * expected))) + expected - self.derivatives * np.pi / 2
        slope = np.imag(q * np.conj(p)) / np.maximum(np.abs(p) ** 2, 1e-300)
        return envelope, phase, slope + self.angular_frequency

    @cached_property
    def measured(self) -> tuple[Array, Array, Array]:
        """Envelope, phase and frequency of the channel itself, with the bias of the transform."""
        return self.seen(self.samples)


@dataclass(frozen=True, eq=False)
class RidgeFit:
    """Envelope and phase models, with the measured envelope (m) and phase (rad) freed of bias, shape (m,).

    Where the rounds that free it do not settle, `ahead` is by what one more would change the parameters of both, (p,).
    """

    envelope_fit: EnvelopeFit
    phase_fit: PhaseFit
    stiffness_orders: tuple[int, ...]
    envelope: Array
    phase: Array
    ahead: Array | None = None

    @property
    def order(self) -> int:
        """The damping order."""
        return len(self.envelope_fit.parameters) - 2


def observe(
    samples: Array, valid: Mask, rate: float, derivatives: int, angular_frequency: float, noise: float
) -> Observed:
    """Prepare the ridge of one channel at `angular_frequency` (rad/s); NotIdentifiable where too few samples are valid."""
    cycle = 2 * np.pi * rate / angular_frequency
    every = max(1, int(cycle / POINTS_PER_CYCLE), -(-len(samples) // _MOST_POINTS))
    points = np.arange(0, len(samples), every)
    width = WIDTH_CYCLES * cycle
    ridge = HarmonicWindows.over(
        valid,
        rate,
        points / rate,
        (ceil(_REACH * width) + 0.5) / rate,
        np.full(len(points), angular_frequency),
        lambda s: np.exp(-0.5 * (s * rate / width) ** 2),
        drift=False,
    )
    widening = np.maximum(ridge.spread * np.sqrt(2 * np.pi) * width / 2, 1.0)
    variance = (
        noise**2 / (np.sqrt(np.pi) * width) * widening / angular_frequency ** (2 * derivatives) + 1e-300
    )
    weight = np.where(ridge.support > 0.3, 1 / np.sqrt(widening), 0.0)
    if not weight.any():
        raise NotIdentifiable("too many samples are lost over the whole motion to follow its envelope")
    return Observed(
        samples, valid, rate, derivatives, angular_frequency, noise, ridge, points, weight, variance
    )


def parameters_of(fit: RidgeFit) -> tuple[dict[int, float], Array]:
    """Return the stiffness k_i by its order i, and the damping mu_0, ... per unit mass."""
    slopes, orders = fit.phase_fit.parameters[1:], fit.stiffness_orders
    w = slopes[0]
    damping = fit.envelope_fit.parameters[1:] / envelope_factors(w, fit.order)
    sizes = 2 * w * slopes / backbone_factors(orders)
    return dict(zip(orders, map(float, sizes), strict=True)) | {1: float(w**2)}, damping


def exact_decay(observed: Observed, fit: RidgeFit) -> Array:
    """Integrate the fitted model over the window from the fitted first amplitude and phase; it may raise RunsAway.

    Returns what the channel would read, (n,).
    """
    stiffness, damping = parameters_of(fit)
    amplitude, *losses = fit.envelope_fit.parameters
    phase, frequency = fit.phase_fit.parameters[:2]
    in_band = 1.0 / _BAND < frequency / observed.angular_frequency < _BAND
    if not in_band or abs(damping[0]) > abs(stiffness[1] * amplitude):
        raise RunsAway
    loss = -np.polynomial.polynomial.polyval(amplitude, losses)
    velocity = loss * np.cos(phase) - frequency * amplitude * np.sin(phase)
    decay = simulate_decay(
        amplitude * np.cos(phase), velocity, stiffness, damping, 1 / observed.rate, len(observed.samples)
    )
    return (decay.displacement, decay.velocity, decay.acceleration)[observed.derivatives]


def simulate_decay(
    displacement: float, velocity: float, stiffness: dict[int, float], damping: Array, step: float, count: int
) -> Response:
    """Simulate u'' = -sum k_i u^i - sum mu_i |u'|^i sgn(u') from a given state; `count` samples `step` s apart.

    `stiffness` holds k_i (per unit mass) by its order i: 1, 3 and 5; `damping` mu_0, mu_1, .... The mass sticks where
    the spring cannot overcome mu_0. Raises RunsAway where a coefficient is no finite number, k_1 lets the mass
    turn more than once between two samples, or the motion grows to a hundred times its start.
    """
    turn = step * sqrt(max(abs(stiffness[1]), 1e-300))
    if not np.isfinite([displacement, velocity, *stiffness.values(), *damping]).all() or turn > 2 * pi:
        raise RunsAway
    higher = [(STIFFNESS_BY_ORDER[i], k, i) for i, k in stiffness.items() if i > 1]
    higher += [
        (DAMPING_BY_ORDER[i] if i < len(DAMPING_BY_ORDER) else POWER_LAW_DAMPING.effect, mu, i)
        for i, mu in enumerate(damping)
        if i > 1
    ]
    mu_0, mu_1 = [*damping, 0.0][:2]
    motion = simulate(
        make_system(tuple(effect for effect, _, _ in higher)),
        np.array([stiffness[1], mu_1, mu_0]),
        np.array([(size, order, 1.0, 0.0, 0.0, 0.0) for _, size, order in higher]).reshape(-1, 6),
        start=(displacement, velocity),
        states=np.zeros((len(higher), 2)),
        samples=count,
        rate=1.0 / step,
        substeps=max(1, ceil(_STEPS_PER_CYCLE * turn / (2 * pi))),
    )
    start = max(abs(displacement), abs(velocity) * step / turn)
    if not np.abs(motion.displacement).max(initial=0.0) <= _RUN_AWAY * start:
        raise RunsAway
    return motion


def seen_of(observed: Observed, fit: RidgeFit) -> tuple[Array, Array]:
    """Return envelope and phase (m,) that the transform shows of the exact decay of a fit; it may raise RunsAway."""
    envelope, phase, _ = observed.seen(exact_decay(observed, fit))
    first = int(np.argmax(observed.weight > 0))  # both begin alike, however far they part
    turns = np.round((phase[first] - fit.phase_fit.fit[first]) / (2 * np.pi))
    return envelope, phase - 2 * np.pi * turns


def first_fit(observed: Observed, order: int, orders: tuple[int, ...]) -> RidgeFit:
    """Fit the ridge as it comes, by eqs. (9)-(12), with nothing taken off yet."""
    envelope, phase, _ = observed.measured
    start = solve_integrated(envelope, observed.step, order, observed.weight)
    fitted = fit_envelope(envelope, observed.step, start, observed.weight)
    phases = fit_phase(phase, envelope, observed.step, orders, observed.weight)
    return RidgeFit(fitted, phases, orders, envelope, phase)


def other_order(observed: Observed, fit: RidgeFit, order: int) -> EnvelopeFit:
    """Fit another damping order to the envelope of `fit`, as it stands freed of bias."""
    start = solve_integrated(fit.envelope, observed.step, order, observed.weight)
    return fit_envelope(fit.envelope, observed.step, start, observed.weight, rounds=2)


def other_backbone(observed: Observed, fit: RidgeFit, orders: tuple[int, ...]) -> PhaseFit:
    """Fit other stiffness orders to the phase of `fit`, as it stands freed of bias."""
    return fit_phase(fit.phase, np.abs(fit.envelope), observed.step, orders, observed.weight)
