"""Curves of some releases, and the effect of each possible law on them: one column a law.

Along the measured amplitudes the logarithm of the amplitude, the phase and the centre of the oscillation are linear in the
strength of every law (Krylov and Bogoliubov 1937). What windows and averaging do to a motion is found by running the laws
through the same windows, and is taken off the measurement.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from identify.arrays import Array
from identify.curves.averaged_law import AveragedLaw, amplitude_grid, inner_of, law_of, laws_of, values_of
from identify.curves.decay_curve import DecayCurve
from identify.curves.isolated_mode import Isolated, simulated_curve
from identify.effects.effect import Scales
from identify.effects.force_effect import LinearPart
from identify.fitting.own_linear import shares_of
from identify.model.model import Model, Term
from identify.priors import BENDS_OVER

_FOLLOWS = 5.0
"""Multiple of the typical loss beyond which a simulated curve no longer follows its laws."""

_BENDS = 3
"""Order of the polynomial in the logarithm of the amplitude that smooths a measured loss."""

Signals = tuple[Array, Array, Array]
"""Log amplitude and phase since the first point, and centre over the largest amplitude: (n,) each, or (n, laws)."""


@dataclass(frozen=True, eq=False)
class CurveLaws:
    """Releases with their curves, and laws: the first `base` laws are those of the model, the others may be missing from it.

    `known` has the model's parameters by unknown's name; `frequency` is the median of all curves, rad/s. `own` are the
    laws at the frequency of each release, the same where all are at one.
    """

    releases: tuple[Isolated, ...]
    laws: tuple[AveragedLaw, ...]
    base: int
    known: dict[str, float]
    scales: Scales
    frequency: float
    own: tuple[tuple[AveragedLaw, ...], ...]

    @classmethod
    def of(
        cls,
        releases: tuple[Isolated, ...],
        model: Model,
        known: dict[str, float],
        terms: tuple[Term, ...],
        scales: Scales,
    ) -> Self:
        """Average the forces of a model and of other terms over the cycles of some releases."""
        curves = tuple(one.curve for one in releases)
        frequency = float(np.median(np.concatenate([curve.frequency for curve in curves])))
        duration = max(float(curve.time[-1]) for curve in curves)
        grid = amplitude_grid(curves)
        base = tuple(law_of(term, inner_of(term, known), frequency, grid, duration) for term in model.forces)
        laws = (*base, *laws_of(terms, frequency, scales, grid, duration))
        own = (laws,) * len(curves)
        if releases[0].decay.window.varies - {"damping"}:  # each release is at another frequency
            medians = (float(np.median(curve.frequency)) for curve in curves)
            own = tuple(
                tuple(law_of(law.term, law.inner, w, grid, duration) for law in laws) for w in medians
            )
        return cls(releases, laws, len(base), known, scales, frequency, own)

    @property
    def curves(self) -> tuple[DecayCurve, ...]:
        """The measured curve of each release."""
        return tuple(one.curve for one in self.releases)

    @cached_property
    def columns(self) -> tuple[Signals, ...]:
        """The effect of each law of unit strength on each curve, (n, laws)."""
        every = range(len(self.laws))
        return tuple(
            self._along(i, curve, every, float(curve.amplitude.max())) for i, curve in enumerate(self.curves)
        )

    @cached_property
    def measured(self) -> tuple[Signals, ...]:
        """The measured values of each curve, (n,)."""
        return tuple(self._seen(curve, float(curve.amplitude.max())) for curve in self.curves)

    @cached_property
    def typical_loss(self) -> float:
        """Mean loss over all curves, 1/s."""
        return float(np.mean([np.mean(np.abs(curve.loss)) for curve in self.curves]))

    @cached_property
    def linear(self) -> tuple[tuple[int, float], ...]:
        """The linear spring and damper of the base, and by how much those of a release may differ (standard deviation)."""
        spring, damper = shares_of(self.releases[0].decay.window.varies)
        varies = {
            LinearPart.STIFFNESS: spring * self.frequency**2,
            LinearPart.DAMPING: damper * self.typical_loss,
        }
        parts = [(column, self.laws[column].term.force.linear_part) for column in range(self.base)]
        return tuple((column, varies[part]) for column, part in parts if part is not None and part in varies)

    @cached_property
    def low(self) -> Array:
        """The least strength of each law, (laws,)."""
        return np.array([law.term.effect.strength.low for law in self.laws])

    @cached_property
    def natural(self) -> Array:
        """Strength at which each law has the effect of the whole spring on loss or frequency, or moves the centre by an
        amplitude, (laws,); 0: at none.
        """
        rates = [
            np.concatenate([2.0 * _slope(each[kind], curve) for each, curve in self._pairs])
            for kind in (0, 1)
        ]
        size = np.concatenate([curve.amplitude for curve in self.curves])
        moved = np.concatenate([each[2] * curve.amplitude.max() for each, curve in self._pairs])
        moved *= self.frequency / np.sqrt(np.mean(size**2))
        most = np.sqrt(np.max([np.mean(effect**2, axis=0) for effect in (*rates, moved)], axis=0))
        return np.where(most > 0.0, self.frequency / np.maximum(most, 1e-200), 0.0)

    @property
    def _pairs(self) -> list[tuple[Signals, DecayCurve]]:
        return list(zip(self.columns, self.curves, strict=True))

    def spring_of(self, column: int) -> int | None:
        """Return the place in the base of the linear law that another law may replace; None where there is none."""
        part = self.laws[column].term.force.may_be_all_of
        parts = [law.term.force.linear_part for law in self.laws[: self.base]]
        return parts.index(part) if part is not None and part in parts else None

    def plausible(self, column: int, strength: float) -> bool:
        """Check that the strength and inner values of a law do not make it the same force as another effect."""
        law = self.laws[column]
        values = law.term.held_values | law.inner | {law.term.effect.strength.name: strength}
        return law.term.effect.plausible(values, self.scales)

    def observed(self, columns: Sequence[int], strengths: Array) -> tuple[Signals, ...]:
        """Correct the measured curves for what windows and averaging do to a motion of some laws.

        `strengths` (releases, columns). What the loss does to the frequency (half of it, squared: a damped oscillator is
        slower) is taken from the measured loss where it is not that of these laws.
        """
        laws = [self.laws[c] for c in columns]
        model, found = Model(tuple(law.term for law in laws)), []
        for i, release in enumerate(self.releases):
            values = self.known | values_of(laws, strengths[i])
            run = simulated_curve(release, model, values)
            excess = None if run is None else self._excess(i, run, columns, strengths[i])
            size, phase, centre = self.measured[i]
            if excess is not None:
                size, phase, centre = size - excess[0], phase - excess[1], centre - excess[2]
            curve = release.curve
            own = -2.0 * _slope(self.columns[i][0][:, list(columns)] @ strengths[i], curve)
            slower = _smooth(-2.0 * _slope(size, curve), curve) ** 2 - own**2
            found.append((size, phase + summed(slower, curve) / (8.0 * self.frequency), centre))
        return tuple(found)

    def _excess(
        self, release: int, run: DecayCurve, columns: Sequence[int], strengths: Array
    ) -> Signals | None:
        """Return the difference of a simulated curve from its own laws; None where it does not follow them at all."""
        unit = float(self.curves[release].amplitude.max())
        own = self._along(release, run, columns, unit)
        size, phase, centre = (
            seen - law @ strengths for seen, law in zip(self._seen(run, unit), own, strict=True)
        )
        follows = np.abs(2.0 * _slope(size, run)).max() < _FOLLOWS * self.typical_loss
        return (size, phase, centre) if follows and np.isfinite(phase).all() else None

    def _along(self, release: int, curve: DecayCurve, columns: Sequence[int], unit: float) -> Signals:
        parts = [self.own[release][c].along(curve) for c in columns]
        loss, stiffness, centre = (np.column_stack([part[kind] for part in parts]) for kind in range(3))
        return -0.5 * summed(loss, curve), 0.5 * summed(stiffness, curve) / self.frequency, centre / unit

    def _seen(self, curve: DecayCurve, unit: float) -> Signals:
        turned = 0.5 * summed(curve.frequency**2, curve) / self.frequency
        return np.log(curve.amplitude / curve.amplitude[0]), turned, curve.centre / unit


def summed(rates: Array, curve: DecayCurve) -> Array:
    """Integrate rates between the points of a curve, (n - 1, ...), from its first point on: (n, ...)."""
    step = curve.step.reshape((-1,) + (1,) * (rates.ndim - 1))
    return np.concatenate([np.zeros((1, *rates.shape[1:])), np.cumsum(rates * step, axis=0)])


def _slope(values: Array, curve: DecayCurve) -> Array:
    """Return the rates between the points of a curve, (n - 1, ...), of values at the points, (n, ...)."""
    return np.asarray(np.diff(values, axis=0) / curve.step.reshape((-1,) + (1,) * (values.ndim - 1)))


def _smooth(rate: Array, curve: DecayCurve) -> Array:
    """Smooth a rate (n - 1,) over the amplitude."""
    size = np.log(curve.between)
    order = min(_BENDS, len(size) - 1) if np.ptp(size) > BENDS_OVER / 8.0 else 0
    series = np.polynomial.polynomial.polyfit(size - size.mean(), rate, order)
    return np.asarray(np.polynomial.polynomial.polyval(size - size.mean(), series))
