"""Harmonic motion under windows: amplitude, phase, slope and centre of an oscillation, along a record with ends and gaps.

Under a window a model `o + d s + Re[(p + q s) e^{iws}]` (s the time from the window's centre) is fitted to the readings
that exist by weighted least squares: p is the analytic signal, free of offset, of the decay's slope and of the missing
readings. Under a Gaussian window, and without the drift d, this is the Morlet transform on its ridge, eq. (7), which
would fall off where half of the window sees nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask

Complex = NDArray[np.complex128]

_RIDGE = 1e-12
"""Share of the window's sum that keeps an empty window solvable; its support says so."""


@dataclass(frozen=True, eq=False)
class HarmonicWindows:
    """Windows of one record; window k begins at sample `first[k]`, shape (k,).

    `operators` (5, m) turn the m readings of each window into Re p, Im p, Re q and Im q (per s), and o. `support` is the
    share of each window that holds readings, (k,); `spread` (k,) is the mean variance of Re p and Im p for white noise of
    variance 1, if it had the window's reciprocal for a weight.
    """

    first: NDArray[np.int_]
    operators: tuple[Array, ...]
    support: Array
    spread: Array

    @classmethod
    def over(
        cls,
        used: Mask,
        rate: float,
        centres: Array,
        half: float,
        frequency: Array,
        window: Callable[[Array], Array],
        *,
        drift: bool,
    ) -> Self:
        """Lay windows of half-width `half` (s) around `centres` (k,) s from the first of the samples, which are `used` (n,).

        `frequency` (k,) is the angular frequency of each in rad/s; `window` gives the weight at times (s) from the centre.
        """
        first, operators, support, spread = [], [], [], []
        for centre, w in zip(centres, frequency, strict=True):
            at = np.arange(int(np.ceil((centre - half) * rate)), int(np.floor((centre + half) * rate)) + 1)
            s = at / rate - centre
            weight = window(s)
            full = float(np.sum(weight))
            inside = (at >= 0) & (at < len(used))
            at, s = at[inside], s[inside]
            weight, x = weight[inside] * used[at], s / half
            cos, sin = np.cos(w * s), np.sin(w * s)
            design = np.array([cos, -sin, x * cos, -x * sin, np.ones(len(s)), x][: 5 + drift])
            inverse = np.linalg.inv((design * weight) @ design.T + _RIDGE * full * np.eye(len(design)))
            operator = inverse[:5] @ (design * weight)
            operator[2:4] /= half
            first.append(int(at[0]))
            operators.append(operator)
            support.append(float(np.sum(weight)) / full)
            spread.append(0.5 * float(inverse[0, 0] + inverse[1, 1]))
        return cls(np.array(first), tuple(operators), np.array(support), np.array(spread))

    def part(self, points: slice) -> Self:
        """Return some of the windows."""
        return type(self)(
            self.first[points], self.operators[points], self.support[points], self.spread[points]
        )

    def __call__(self, values: Array) -> tuple[Complex, Complex, Array]:
        """Return p, q (per s) and o of values (n,) under each window, (k,) each.

        The modulus of p is the envelope, its argument the phase, eq. (8).
        """
        found = np.array([o @ part for o, part in zip(self.operators, self._parts(values), strict=True)])
        return found[:, 0] + 1j * found[:, 1], found[:, 2] + 1j * found[:, 3], found[:, 4]

    def mean_square(self, values: Array, level: Array) -> Array:
        """Return the mean square of values (n,) about a level (k,) under each window, all readings alike, (k,)."""
        return np.array(
            [np.mean((part - at) ** 2) for part, at in zip(self._parts(values), level, strict=True)]
        )

    def _parts(self, values: Array) -> list[Array]:
        return [values[a : a + o.shape[1]] for a, o in zip(self.first, self.operators, strict=True)]

    def weights_on_samples(self, weights: Complex, count: int) -> Array:
        """Return the weight of each of `count` readings in `Re sum_k conj(weights[:, k]) p_k`, shape (r, n).

        It carries white noise of the readings into anything linear in p; `weights` has shape (r, k).
        """
        total = np.zeros((len(weights), count))
        for k, (a, operator) in enumerate(zip(self.first, self.operators, strict=True)):
            parts = np.stack([weights[:, k].real, weights[:, k].imag], axis=1)
            total[:, a : a + operator.shape[1]] += parts @ operator[:2]
        return total
