"""Shares: what each effect of a model does at the largest and at the smallest amplitude of a record.

Over a cycle of a harmonic motion an effect has a largest force, takes a part of what is lost, and shifts the frequency
(equivalent linearisation, Krylov and Bogoliubov 1937). Standard errors follow from the fit's covariance by the delta
method: the parameters are moved one at a time, and what the shares change by is their derivative.
"""

from dataclasses import dataclass, field

import numpy as np

from identify.arrays import Array
from identify.effects.force_effect import LinearPart
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.formatting import quantity, scaled
from identify.model.equivalent_linearisation import average, force_over_cycle
from identify.model.model import Term
from identify.model.parameter_id import values_in_release
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.oscillation import running_amplitude
from identify.summary import Summary

_COLUMNS = 5
_STEP = 0.1
"""Step of a derivative in standard errors of the parameter, and at most as a share of its value."""

_WHOLE = 100.0
"""Standard error, in % of all forces or of the whole loss, beyond which a record does not determine a share."""

_NOTHING = 1e-12
"""Share of all loss, or of the squared frequency, below which an effect has none: what rounding leaves."""


@dataclass(frozen=True)
class EffectShare:
    """One effect over a cycle, with standard errors.

    `force` is its largest force (N or N m with a mass, whose own error is left out, else per unit mass), `force_percent`
    that in % of the largest of all forces but the linear spring's together; the largest lie at different places of a
    cycle, so they need not add up to 100 %. `loss_percent` is its part of the energy that is lost, `frequency_hz` by how
    much it raises the frequency, and `frequency_percent` the same in %.
    """

    effect: str
    force: Estimate
    force_percent: Estimate
    loss_percent: Estimate
    frequency_hz: Estimate
    frequency_percent: Estimate


@dataclass(frozen=True)
class AmplitudeShares:
    """The shares of all forces but the linear spring at an `amplitude` (in `unit`), where the `frequency` is in Hz."""

    amplitude: float
    unit: str
    frequency: float
    effects: tuple[EffectShare, ...]


def shares(decays: tuple[PreparedDecay, ...], found: Fit) -> tuple[AmplitudeShares, ...]:
    """Compute the shares at the largest and at the smallest amplitude of some whole releases, in this order.

    `found` has the standard errors that are to be stated. A parameter at a bound, or not determined, is held for the
    errors of the other effects; the effect's own are then infinite. A line, which does not follow the motion, takes no
    part in loss and frequency: nan. So is a share with an error above 100 %. Empty where a driven
    motion has no amplitude of its own, where nothing but a spring acts, and where no share is determined.
    """
    if any(decay.window.force is not None for decay in decays):
        return ()
    masses = {decay.mass for decay in decays}
    mass = masses.pop() if len(masses) == 1 else None
    unit = decays[0].window.unit
    ends = [_at(found, amplitude, time, unit, mass) for amplitude, time in _ends(decays)]
    known = tuple(end for end in ends if end is not None)
    return known if any(np.isfinite(one.force.value) for end in known for one in end.effects) else ()


def shares_summary(found: tuple[AmplitudeShares, ...]) -> Summary | None:
    """Summarize the shares as a table; None where there are none."""
    if not found:
        return None
    rows = [
        (
            one.effect,
            scaled(at.amplitude, at.unit),
            *(
                "-" if np.isnan(share.value) else quantity(share)
                for share in (one.force, one.force_percent, one.loss_percent, one.frequency_percent)
            ),
        )
        for at in found
        for one in at.effects
    ]
    head = ("effect", "amplitude", "largest force", "of all forces", "of the loss", "raises the frequency by")
    return Summary("What each effect does", (), head, rows)


def _ends(decays: tuple[PreparedDecay, ...]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the largest and the smallest amplitude, each with its time since the release, s."""
    first = max(decays, key=lambda decay: decay.amplitude)
    last = [(_last_amplitude(decay), float(decay.time[-1])) for decay in decays]
    return (first.amplitude, float(first.time[0])), min(last)


def _last_amplitude(decay: PreparedDecay) -> float:
    period = max(round(2.0 * np.pi / decay.frequency * decay.window.rate), 2)
    return float(running_amplitude(decay.motion.displacement, period)[-1])


@dataclass(frozen=True, eq=False)
class _Cycle:
    """The forces of a model over one cycle of some `amplitude`, `time` s after the release; `frequency` in rad/s."""

    terms: tuple[Term, ...]
    amplitude: float
    time: float
    frequency: float
    known: dict[tuple[str, frozenset[tuple[str, float]]], tuple[float, float, Array]] = field(
        default_factory=dict
    )

    def action(self, term: Term, values: dict[str, float]) -> tuple[float, float, Array]:
        """Return the damping (1/s), the change of w^2 (1/s^2) and the force (n,), m/s^2, of one effect at some values.

        Of a line the force is its amplitude, and the others are nan, as they are where a memory does not become periodic.
        """
        shared = {name: values[name] for name in term.force.shared_parameters}
        own = shared | {p.name: values[str(term.parameter(p.name))] for p in term.free} | term.held_values
        key = term.effect.name, frozenset(own.items())
        if key not in self.known:
            self.known[key] = self._action(term, own)
        return self.known[key]

    def _action(self, term: Term, own: dict[str, float]) -> tuple[float, float, Array]:
        if term.effect.line:
            return np.nan, np.nan, np.array([abs(own[term.effect.strength.name])])
        found = average(term.force, own, self.frequency, np.array([self.amplitude]), time=self.time)
        force = force_over_cycle(term.force, own, self.frequency, self.amplitude, self.time)
        if not found.settled:
            return np.nan, np.nan, force
        return float(found.damping[0]), float(found.stiffening[0]), force

    def columns(self, values: dict[str, float]) -> Array:
        """Return largest force, its share in %, share of the loss in %, shift in Hz and in % of each force, (terms, 5)."""
        actions = [self.action(term, values) for term in self.terms]
        peaks = np.array([float(np.max(np.abs(force))) for _, _, force in actions])
        lines = np.array([term.effect.line for term in self.terms])
        moving = [force for (_, _, force), line in zip(actions, lines, strict=True) if not line]
        whole = peaks[lines].sum() + (float(np.max(np.abs(np.sum(moving, axis=0)))) if moving else 0.0)
        damping, stiffening = (np.array([action[place] for action in actions]) for place in (0, 1))
        lost, size = float(np.nansum(damping)), float(np.nansum(np.abs(damping)))
        damping[np.abs(damping) < _NOTHING * size] = 0.0
        stiffening[np.abs(stiffening) < _NOTHING * self.frequency**2] = 0.0
        loss = damping / lost if abs(lost) > _NOTHING * self.frequency else np.full(len(actions), np.nan)
        shift = self.frequency - np.sqrt(np.maximum(self.frequency**2 - stiffening, 0.0))
        hertz, percent = shift / (2.0 * np.pi), 100.0 * shift / self.frequency
        return np.column_stack([peaks, 100.0 * peaks / max(whole, 1e-300), 100.0 * loss, hertz, percent])

    def errors(self, fit: Fit, values: dict[str, float]) -> Array:
        """Return the standard errors of the same columns, by the delta method, the frequency held, (terms, 5)."""
        known = [
            at
            for at, unknown in enumerate(fit.unknowns)
            if unknown.name in values and np.isfinite(fit.values[unknown.name].std)
        ]
        gradient = np.zeros((len(known), len(self.terms), _COLUMNS))
        for row, at in enumerate(known):
            gradient[row] = self._slope(fit, at, values)
        covariance = fit.covariance[np.ix_(known, known)]
        std = np.sqrt(np.maximum(np.einsum("pij,pq,qij->ij", gradient, covariance, gradient), 0.0))
        for i, term in enumerate(self.terms):
            own = fit.of(term, 0)
            if not all(np.isfinite(own[p.name].std) for p in term.free):
                std[i] = np.inf
        return np.asarray(std)

    def _slope(self, fit: Fit, at: int, values: dict[str, float]) -> Array:
        """Return the derivative of the columns with respect to one unknown, within its bounds."""
        unknown = fit.unknowns[at]
        value, std = values[unknown.name], fit.values[unknown.name].std
        step = _STEP * (min(std, abs(value)) if value != 0.0 else std)
        low, high = max(value - step, unknown.low), min(value + step, unknown.high)
        first, last = (self.columns(values | {unknown.name: end}) for end in (low, high))
        return np.nan_to_num((last - first) / (high - low)) if high > low else np.zeros_like(first)


def _at(found: Fit, amplitude: float, time: float, unit: str, mass: float | None) -> AmplitudeShares | None:
    shared = {name: estimate.value for name, estimate in found.parameters.items()}
    values = values_in_release(shared, 0)
    spring = found.model.linear_strength(LinearPart.STIFFNESS)
    terms = tuple(t for t in found.model.forces if t.force.linear_part is not LinearPart.STIFFNESS)
    if not terms:
        return None
    cycle = _Cycle(terms, amplitude, time, found.frequency)
    if spring is not None:
        squared = values[str(spring)] + float(np.nansum([cycle.action(term, values)[1] for term in terms]))
        if squared > 0.0:
            cycle = _Cycle(terms, amplitude, time, float(np.sqrt(squared)))
    columns, std = cycle.columns(values), cycle.errors(found, values)
    scale, force = _force_unit(unit, mass)
    columns[:, 0] *= scale
    std[:, 0] *= scale
    unknown = np.isfinite(std[:, 1:3]) & (std[:, 1:3] > _WHOLE)  # share of all forces, and of the loss
    columns[unknown[:, 0]] = np.nan
    columns[unknown[:, 1], 2] = np.nan
    units = (force, "%", "%", "Hz", "%")
    effects = tuple(
        EffectShare(
            term.effect.name,
            *(Estimate(float(v), float(s), u) for v, s, u in zip(columns[i], std[i], units, strict=True)),
        )
        for i, term in enumerate(terms)
    )
    return AmplitudeShares(amplitude, unit, cycle.frequency / (2.0 * np.pi), effects)


def _force_unit(unit: str, mass: float | None) -> tuple[float, str]:
    """Return the factor from a force per unit mass to the force that is stated, and its unit."""
    named = {"m": "N", "rad": "N m"}
    return (1.0, f"{unit}/s^2") if mass is None or unit not in named else (mass, named[unit])
