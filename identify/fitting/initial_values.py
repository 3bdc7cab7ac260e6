"""Where a fit may begin: strengths by equation error, inner parameters by the effects' own rules, states by the motion."""

from dataclasses import replace

import numpy as np

from identify.effects.effect import Scales
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.model.parameter_id import ParameterId, nuisance
from identify.preprocessing.equation_error import Regression, moving, regress
from identify.preprocessing.prepared_decay import PreparedDecay


def initial_values(
    decays: tuple[PreparedDecay, ...], model: Model, inner: dict[str, float]
) -> dict[str, float]:
    """Return where a fit may begin, by unknown's name: strengths by equation error, the states from the motions.

    `inner` gives inner parameters by "effect.parameter". The strengths come from the release of the largest amplitude.
    """
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    values = dict(inner)
    for term, strength in zip(model.forces, regress_model(largest, model, inner).strengths, strict=True):
        parameter = term.effect.strength
        values[str(term.strength)] = float(np.clip(strength, parameter.low, parameter.high))
    if any(prepared.window.estimates_mass for prepared in decays):
        values[str(nuisance("force_gain"))] = 1.0
    for i, prepared in enumerate(decays):
        own = _of_release(prepared, model.forces, inner)
        values |= {str(id.of_release(i, len(decays))): value for id, value in own.items()}
    return values


def rest_states(
    term: Term, displacement: float, velocity: float, inner: dict[str, float]
) -> dict[ParameterId, float]:
    """Return the internal states of an effect with memory soon after the release, as if it were the only release."""
    effect = term.force
    if effect.equilibrium_state is None:
        return {}
    values = {effect.strength.name: 0.0} | inner_values(term, inner)
    first, second = effect.equilibrium_state(
        displacement, np.array([values[p.name] for p in effect.parameters])
    )
    states = {term.state(0): first}
    if effect.states > 1:
        states[term.state(1)] = second or velocity
    return states


def inner_values(term: Term, inner: dict[str, float]) -> dict[str, float]:
    """Return the inner parameters of a force by their own names: those that are held, others from `inner` by full name."""
    given = {p.name: inner[str(term.parameter(p.name))] for p in term.free if p.name in term.effect.inner}
    return given | term.held_values


def _of_release(
    prepared: PreparedDecay, terms: tuple[Term, ...], inner: dict[str, float]
) -> dict[ParameterId, float]:
    """Return where the state, lag, gain and offsets of one release may begin, as if it were the only one."""
    motion, window = prepared.motion, prepared.window
    u, v = float(motion.displacement[0]), float(motion.velocity[0])
    gain = prepared.alignment.gain.value if prepared.alignment is not None else 1.0
    values = {"displacement": u, "velocity": v, "lag": window.lag, "gain": gain}
    if "displacement" in window.readings:
        values["displacement_offset"] = prepared.zero
    if "acceleration" in window.readings:
        used = window.used["acceleration"]
        values["acceleration_offset"] = float(
            np.median((window.readings["acceleration"] - gain * motion.acceleration)[used])
        )
    found = {nuisance(name): value for name, value in values.items()}
    for term in terms:
        found |= rest_states(term, u, v, inner)
    return found


def regress_model(prepared: PreparedDecay, model: Model, inner: dict[str, float]) -> Regression:
    """Regress the measured restoring force on the forces of a model at given inner parameters.

    Where the mass was only estimated, what the external force should be corrected by is regressed too.
    """
    motion = prepared.motion
    along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
    columns = [force_along(term, inner_values(term, inner), *along) for term in model.forces]
    noise = motion.noise_acceleration or 1.0
    if not prepared.window.estimates_mass:
        return regress(prepared.restoring, np.column_stack(columns), moving(motion), noise)
    assert prepared.window.force is not None
    columns.append(-prepared.window.force)
    found = regress(prepared.restoring, np.column_stack(columns), moving(motion), noise)
    return replace(found, strengths=found.strengths[:-1])


def scales_of(prepared: PreparedDecay, lines: dict[str, tuple[tuple[float, float, float], ...]]) -> Scales:
    """Return the sizes from which effects take their starting values."""
    window = prepared.window
    return Scales(
        amplitude=prepared.amplitude,
        frequency=prepared.frequency,
        duration=len(window) / window.rate,
        rate=window.rate,
        peaks={c: float(np.max(np.abs(window.readings[c][window.used[c]]))) for c in window.channels},
        lines=lines,
    )


def term_starts(term: Term, scales: Scales, *, fine: bool = False) -> tuple[dict[str, float], ...]:
    """Return the starting values of a term's inner parameters by their own names, of a fault those of all parameters.

    `fine` ones leave no gaps between them.
    """
    effect = term.effect
    starts = (effect.fine_starting_values if fine else effect.starting_values)(scales, term.channel)
    names = [p.name for p in effect.started if p.name not in term.held]
    return tuple(dict(zip(names, start, strict=True)) for start in starts)
