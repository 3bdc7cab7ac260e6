"""One channel's ridge: its envelope and phase as the transform shows them, of what was measured and of a computed decay.

Averaging is first order in the damping, a window is one-sided at the ends of a record, and dry friction shifts the
displacement's phase. All three are the same for the measured decay and for a computed one with the same parameters: a
model is integrated exactly, and sent through the same transform.
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

WIDTH_CYCLES = 1.0  # standard deviation of the window: the third harmonic is 12 of its bandwidths away
POINTS_PER_CYCLE = 4
_REACH = 4.0  # the window is cut at 4 standard deviations, where it is 3e-4
_MOST_POINTS = 400
STEPS_PER_CYCLE = 200  # the frequency of a fourth-order step is then off by 1e-8
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
        """Return displacement's envelope, phase (rad) and frequency (rad/s) at the points, (m,).

        Of several channels at once, samples (n, q), that is (q, m).
        """
        p, q, _ = (found.T for found in self.ridge(samples))
        envelope = np.abs(p) / self.angular_frequency**self.derivatives
        expected = self.angular_frequency * self.points / self.rate
        phase = np.unwrap(np.angle(p * np.exp(-1j * expected))) + expected - self.derivatives * np.pi / 2
        slope = np.imag(q * np.conj(p)) / np.maximum(np.abs(p) ** 2, 1e-300)
        return envelope, phase, slope + self.angular_frequency

    @cached_property
    def inverse_noise(self) -> Array:
        """One over the standard deviation of the envelope's noise, (m,); 0 where there is nothing to read."""
        return np.asarray((self.weight > 0) / np.sqrt(self.variance))

    @cached_property
    def measured(self) -> tuple[Array, Array, Array]:
        """Envelope, phase and frequency of the channel itself, with the bias of the transform."""
        return self.seen(self.samples)


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
    least = 1e-9 * float(np.ptp(samples))  # without noise all is sure, to rounding
    variance = (
        (noise**2 + least**2) / (np.sqrt(np.pi) * width) * widening / angular_frequency ** (2 * derivatives)
    )
    weight = np.where(ridge.support > 0.3, 1 / np.sqrt(widening), 0.0)
    if not weight.any():
        raise NotIdentifiable("too many samples are lost over the whole motion to follow its envelope")
    return Observed(
        samples, valid, rate, derivatives, angular_frequency, noise, ridge, points, weight, variance
    )


def values_of(theta: Array, orders: tuple[int, ...]) -> tuple[dict[int, float], Array]:
    """Return the stiffness k_i by its order i, and the damping mu_0, ..., per unit mass.

    `theta` (p,) is k(0), c_0, ..., phi(0), w_1, ... with slopes of the odd stiffness `orders`.
    """
    losses, slopes = theta[1 : -1 - len(orders)], theta[-len(orders) :]
    w = slopes[0]
    sizes = 2 * w * slopes / backbone_factors(orders)
    stiffness = dict(zip(orders, map(float, sizes), strict=True)) | {1: float(w**2)}
    return stiffness, losses / envelope_factors(w, len(losses) - 1)


def exact_decay(
    observed: Observed, theta: Array, orders: tuple[int, ...], steps: int = STEPS_PER_CYCLE
) -> Array:
    """Integrate the model `theta` over the window, from its first amplitude and phase, with so many `steps` to a cycle.

    Returns what the channel would read, (n,); it may raise RunsAway.
    """
    stiffness, damping = values_of(theta, orders)
    amplitude, losses = theta[0], theta[1 : -1 - len(orders)]
    phase, frequency = theta[-1 - len(orders) :][:2]
    in_band = 1.0 / _BAND < frequency / observed.angular_frequency < _BAND
    if not in_band or abs(damping[0]) > abs(stiffness[1] * amplitude):
        raise RunsAway
    loss = -np.polynomial.polynomial.polyval(amplitude, losses)
    velocity = loss * np.cos(phase) - frequency * amplitude * np.sin(phase)
    decay = simulate_decay(
        amplitude * np.cos(phase),
        velocity,
        stiffness,
        damping,
        1 / observed.rate,
        len(observed.samples),
        steps,
    )
    return (decay.displacement, decay.velocity, decay.acceleration)[observed.derivatives]


def simulate_decay(
    displacement: float,
    velocity: float,
    stiffness: dict[int, float],
    damping: Array,
    step: float,
    count: int,
    steps: int = STEPS_PER_CYCLE,
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
        substeps=max(1, ceil(steps * turn / (2 * pi))),
    )
    start = max(abs(displacement), abs(velocity) * step / turn)
    if not np.abs(motion.displacement).max(initial=0.0) <= _RUN_AWAY * start:
        raise RunsAway
    return motion
