"""Shares: what each effect of a model does at the largest and at the smallest amplitude of a record.

Over a cycle of a harmonic motion an effect has a largest force, takes a part of what is lost, and shifts the frequency
(equivalent linearisation, Krylov and Bogoliubov 1937). Standard errors follow from the fit's covariance by the delta
method: the parameters are moved one at a time, and what the shares change by is their derivative.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array
from identify.effects.force_effect import LinearPart
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.formatting import quantity, scaled
from identify.model.equivalent_linearisation import average, force_over_cycle
from identify.model.model import Term
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
    """What one effect does over a cycle, with standard errors.

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
    """Return the shares at the largest and at the smallest amplitude of some whole releases, in this order.

    `found` has the standard errors that are to be stated. A parameter at a bound, or not determined, is held for the
    errors of the other effects; the effect's own are then infinite. A line, which does not follow the motion, takes no
    part in loss and frequency: nan. So is what the record leaves uncertain by more than the whole. Empty where a driven
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
    """Return the shares as a table to be printed; None where there are none."""
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
class _Action:
    """What one force does over a cycle: `damping` (1/s), change of w^2 `stiffening` (1/s^2), and the force (n,), m/s^2.

    Of a line the force is its amplitude, and the others are nan, as they are where a memory does not become periodic.
    """

    damping: float
    stiffening: float
    force: Array
    line: bool


@dataclass(frozen=True, eq=False)
class _Cycle:
    """The forces of a model over one cycle of some `amplitude`, `time` s after the release; `frequency` in rad/s."""

    terms: tuple[Term, ...]
    amplitude: float
    time: float
    frequency: float

    def action(self, term: Term, values: dict[str, float]) -> _Action:
        """Return what one force does at some values, by unknown's name."""
        own = values | {p.name: values[str(term.parameter(p.name))] for p in term.free} | term.held_values
        if term.effect.line:
            return _Action(np.nan, np.nan, np.array([abs(own[term.effect.strength.name])]), True)
        found = average(term.force, own, self.frequency, np.array([self.amplitude]), time=self.time)
        force = force_over_cycle(term.force, own, self.frequency, self.amplitude, self.time)
        if not found.settled:
            return _Action(np.nan, np.nan, force, False)
        return _Action(float(found.damping[0]), float(found.stiffening[0]), force, False)

    def columns(self, actions: Sequence[_Action]) -> Array:
        """Return largest force, its share in %, share of the loss in %, shift in Hz and in % of each force, (terms, 5)."""
        peaks = np.array([float(np.max(np.abs(action.force))) for action in actions])
        whole = sum(peak for peak, action in zip(peaks, actions, strict=True) if action.line)
        moving = [action.force for action in actions if not action.line]
        whole += float(np.max(np.abs(np.sum(moving, axis=0)))) if moving else 0.0
        damping = np.array([action.damping for action in actions])
        stiffening = np.array([action.stiffening for action in actions])
        lost, size = float(np.nansum(damping)), float(np.nansum(np.abs(damping)))
        damping[np.abs(damping) < _NOTHING * size] = 0.0
        stiffening[np.abs(stiffening) < _NOTHING * self.frequency**2] = 0.0
        loss = damping / lost if abs(lost) > _NOTHING * self.frequency else np.full(len(actions), np.nan)
        shift = self.frequency - np.sqrt(np.maximum(self.frequency**2 - stiffening, 0.0))
        hertz, percent = shift / (2.0 * np.pi), 100.0 * shift / self.frequency
        return np.column_stack([peaks, 100.0 * peaks / max(whole, 1e-300), 100.0 * loss, hertz, percent])

    def errors(self, fit: Fit, values: dict[str, float], actions: Sequence[_Action]) -> Array:
        """Return the standard errors of the same columns, by the delta method, the frequency held, (terms, 5)."""
        known = [
            at
            for at, unknown in enumerate(fit.unknowns)
            if unknown.name in values and np.isfinite(fit.values[unknown.name].std)
        ]
        gradient = np.zeros((len(known), len(actions), _COLUMNS))
        for row, at in enumerate(known):
            gradient[row] = self._slope(fit, at, values, actions)
        covariance = fit.covariance[np.ix_(known, known)]
        std = np.sqrt(np.maximum(np.einsum("pij,pq,qij->ij", gradient, covariance, gradient), 0.0))
        for i, term in enumerate(self.terms):
            if not all(np.isfinite(fit.values[str(term.parameter(p.name))].std) for p in term.free):
                std[i] = np.inf
        return np.asarray(std)

    def _slope(self, fit: Fit, at: int, values: dict[str, float], actions: Sequence[_Action]) -> Array:
        """Return the derivative of the columns with respect to one unknown, within its bounds."""
        unknown = fit.unknowns[at]
        value, std = values[unknown.name], fit.values[unknown.name].std
        step = _STEP * (min(std, abs(value)) if value != 0.0 else std)
        low, high = max(value - step, unknown.low), min(value + step, unknown.high)
        ends = [
            self.columns(
                [
                    self.action(term, values | {unknown.name: end}) if _moves(unknown.name, term) else old
                    for term, old in zip(self.terms, actions, strict=True)
                ]
            )
            for end in (low, high)
        ]
        return np.nan_to_num((ends[1] - ends[0]) / (high - low)) if high > low else np.zeros_like(ends[0])


def _moves(name: str, term: Term) -> bool:
    """Whether a force depends on an unknown, its own or shared."""
    return name in term.force.shared_parameters or name in {str(term.parameter(p.name)) for p in term.free}


def _at(found: Fit, amplitude: float, time: float, unit: str, mass: float | None) -> AmplitudeShares | None:
    values = {name: estimate.value for name, estimate in found.parameters.items()}
    spring = found.model.linear_strength(LinearPart.STIFFNESS)
    terms = tuple(t for t in found.model.forces if t.force.linear_part is not LinearPart.STIFFNESS)
    if not terms:
        return None
    cycle = _Cycle(terms, amplitude, time, found.frequency)
    actions = [cycle.action(term, values) for term in terms]
    if spring is not None:
        squared = values[str(spring)] + float(np.nansum([action.stiffening for action in actions]))
        if squared > 0.0:
            cycle = replace(cycle, frequency=float(np.sqrt(squared)))
            actions = [cycle.action(term, values) for term in terms]
    columns, std = cycle.columns(actions), cycle.errors(found, values, actions)
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
