"""An averaged law: what an effect of unit strength does to loss, frequency and centre at every amplitude."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.curves.decay_curve import DecayCurve
from identify.effects.effect import Scales
from identify.effects.force_effect import ForceEffect
from identify.fitting.initial_values import starts_between
from identify.model.equivalent_linearisation import Signature, average
from identify.model.model import Term

_AMPLITUDES = 14
_TIMES = 9
_SHAPELESS = 1e-3


@dataclass(frozen=True, eq=False)
class AveragedLaw:
    """The signature of a term at unit strength over a grid of amplitudes, and of times where it depends on time.

    `inner` are the inner parameters, by their own names; `signatures` are those at each of `times` (times,) s since the
    release, one where time does not matter, and `centre` (amplitudes,) is the displacement of the centre by a force that
    is even.
    """

    term: Term
    inner: dict[str, float]
    amplitudes: Array
    times: Array
    signatures: tuple[Signature, ...]
    centre: Array

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name

    def along(self, curve: DecayCurve) -> tuple[Array, Array, Array]:
        """Return loss (1/s) and change of w^2 (1/s^2) between the points, (n - 1,), and the centre at them, (n,)."""
        at, grid = np.log(curve.between), np.log(self.amplitudes)
        loss = self._in_time(curve, [np.interp(at, grid, s.damping) for s in self.signatures])
        stiffening = self._in_time(curve, [np.interp(at, grid, s.stiffening) for s in self.signatures])
        centre = np.interp(np.log(curve.amplitude), grid, self.centre)
        return curve.lightness * loss, curve.lightness * stiffening, curve.lightness * centre

    def _in_time(self, curve: DecayCurve, values: list[Array]) -> Array:
        """Interpolate values that hold at each of the times to the points of a curve, (n,)."""
        if len(values) == 1:
            return values[0]
        along = zip(curve.clock, np.transpose(values), strict=True)
        return np.array([np.interp(time, self.times, at_times) for time, at_times in along])

    @property
    def shapeless(self) -> bool:
        """Whether the curves cannot tell the effect from a linear spring and damper.

        Nor from a damper that walks at random, which every hypothesis has: a loss that changes with time.
        """
        if self.term.effect.of_time:
            return all(
                not np.abs(one.stiffening).max() > _SHAPELESS * np.abs(one.damping).max()
                for one in self.signatures
            )
        some = [0, len(self.amplitudes) // 2, -1]
        (signature,) = self.signatures
        for values in (signature.damping[some], signature.stiffening[some]):
            if np.ptp(values) > _SHAPELESS * max(float(np.abs(values).max()), 1e-300):
                return False
        return bool(np.abs(self.centre[some]).max() < _SHAPELESS * self.amplitudes.max())


def amplitude_grid(curves: Iterable[DecayCurve]) -> Array:
    """Choose the amplitudes at which the laws of some curves are tabulated."""
    sizes = np.concatenate([curve.amplitude for curve in curves])
    return np.geomspace(0.9 * float(sizes.min()), 1.1 * float(sizes.max()), _AMPLITUDES)


def laws_of(
    terms: Iterable[Term],
    frequency: float,
    scales: Scales,
    grid: Array,
    duration: float,
) -> tuple[AveragedLaw, ...]:
    """Average the laws of forces at some values of their inner parameters, leaving out those without a shape.

    `frequency` in rad/s, `grid` the amplitudes, `duration` in s. Lines have none, nor what is proportional. The shape of
    a force with memory depends most on its inner parameter, which is tried twice as densely.
    """
    laws = []
    for term in terms:
        if not isinstance(term.effect, ForceEffect) or term.effect.line or term.effect.proportional:
            continue
        for inner in starts_between(term, scales, times=1 if term.effect.fading_memory else 2):
            law = law_of(term, inner, frequency, grid, duration)
            if not law.shapeless:
                laws.append(law)
    return tuple(laws)


def law_of(
    term: Term, inner: dict[str, float], frequency: float, grid: Array, duration: float
) -> AveragedLaw:
    """Average the law of one force at inner values by their own names.

    It is of first order in the strength, so that it is the same in all units: what even harmonics do to the frequency
    (k2^2 A^2) is no multiple of it, and comes with the simulated motion.
    """
    effect = term.force
    shared = {name: rough(frequency) for name, rough in effect.shared_parameters.items()}
    values = term.held_values | inner | {effect.strength.name: 1.0} | shared
    times = duration * np.linspace(0.0, 1.0, _TIMES) ** 2 if effect.of_time else np.zeros(1)
    signatures = tuple(
        average(effect, values, frequency, grid, time=float(t), second_order=False) for t in times
    )
    moves = effect.force is not None and effect.rates is None  # the centre
    centre = -signatures[0].mean / frequency**2 if moves else np.zeros(len(grid))
    return AveragedLaw(term, dict(inner), grid, times, signatures, centre)


def values_of(laws: Iterable[AveragedLaw], strengths: Array) -> dict[str, float]:
    """Return the parameters of laws at some strengths, by unknown's name."""
    values: dict[str, float] = {}
    for law, strength in zip(laws, strengths, strict=True):
        values |= law.term.by_name(law.inner | {law.term.effect.strength.name: float(strength)})
    return values


def inner_of(term: Term, values: dict[str, float]) -> dict[str, float]:
    """Return the inner parameters of a term by their own names, from values by unknown's name."""
    return {p.name: values[str(term.parameter(p.name))] for p in term.free if p.name in term.effect.inner}
