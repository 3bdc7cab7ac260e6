"""Where a fit may begin: strengths by equation error, inner parameters by the effects' own rules, states by the motion."""

from dataclasses import replace

import numpy as np

from identify.effects.effect import Scales
from identify.fitting.problem import LINEAR
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.equation_error import Regression, moving, regress
from identify.preprocessing.prepared_decay import PreparedDecay


def initial_values(
    decays: tuple[PreparedDecay, ...], model: Model, inner: dict[str, float]
) -> dict[str, float]:
    """Return where a fit may begin, by unknown's name: strengths by equation error, the states from the motions.

    `inner` gives inner parameters by "effect.parameter". The strengths come from the release of the largest amplitude.
    """
    largest = max(decays, key=lambda prepared: prepared.amplitude)
    terms = [t for t in model.terms if t.effect.kind == "physics"]
    values = dict(inner)
    for term, strength in zip(terms, regress_model(largest, model, inner).strengths, strict=True):
        parameter = term.effect.strength
        values[f"{term.effect.name}.{parameter.name}"] = float(
            np.clip(strength, parameter.low, parameter.high)
        )
    if any(prepared.window.estimates_mass for prepared in decays):
        values["force_gain"] = 1.0
    for i, prepared in enumerate(decays):
        tag = f"[{i}]" if len(decays) > 1 else ""
        values |= {f"{name}{tag}": value for name, value in _nuisances(prepared, terms, inner).items()}
    return values


def rest_states(
    term: Term, displacement: float, velocity: float, inner: dict[str, float]
) -> dict[str, float]:
    """Return the internal states of an effect with memory soon after the release, by unknown's name without tag."""
    effect = term.effect
    if effect.equilibrium_state is None:
        return {}
    p = np.array([0.0] + [_inner_value(term, q.name, inner) for q in effect.parameters[1:]])
    first, second = effect.equilibrium_state(displacement, p)
    states = {f"{effect.name}.state0": first}
    if effect.states > 1:
        states[f"{effect.name}.state1"] = second or velocity
    return states


def _inner_value(term: Term, name: str, inner: dict[str, float]) -> float:
    held = term.held.get(name)
    return float(held) if held is not None else inner[f"{term.effect.name}.{name}"]


def _nuisances(prepared: PreparedDecay, terms: list[Term], inner: dict[str, float]) -> dict[str, float]:
    motion, window = prepared.motion, prepared.window
    u, v = float(motion.displacement[0]), float(motion.velocity[0])
    gain = prepared.alignment.gain.value if prepared.alignment is not None else 1.0
    values = {"displacement": u, "velocity": v, "lag": window.lag, "gain": gain}
    for term in terms:
        values |= rest_states(term, u, v, inner)
    if "displacement" in window.readings:
        values["displacement_offset"] = prepared.zero
    if "acceleration" in window.readings:
        used = window.used["acceleration"]
        values["acceleration_offset"] = float(
            np.median((window.readings["acceleration"] - gain * motion.acceleration)[used])
        )
    return values


def regress_model(prepared: PreparedDecay, model: Model, inner: dict[str, float]) -> Regression:
    """Regress the measured restoring force on the forces of a model at given inner parameters.

    Where the mass was only estimated, what the external force should be corrected by is regressed too.
    """
    motion = prepared.motion
    shared = {"linear_stiffness.k": prepared.frequency**2}
    columns = []
    for term in model.terms:
        effect = term.effect
        if effect.kind != "physics":
            continue
        values = {
            p.name: inner[f"{effect.name}.{p.name}"]
            for p in effect.parameters[1:]
            if p.name not in term.held and effect.name not in LINEAR
        }
        columns.append(force_along(term, values, prepared.time, motion.displacement, motion.velocity, shared))
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


def term_starts(term: Term, scales: Scales) -> tuple[dict[str, float], ...]:
    """Return the starting values of a term's inner parameters, by "effect.parameter"."""
    effect = term.effect
    if effect.kind == "sensor":
        if term.channel not in scales.peaks:
            return ()
        starts = effect.sensor_starts(scales, term.channel)
        return tuple(
            {f"{effect.name}.{p.name}": v for p, v in zip(effect.parameters, s, strict=True)} for s in starts
        )
    inner = [p for p in effect.parameters[1:] if p.name not in term.held]
    return tuple(
        {f"{effect.name}.{p.name}": v for p, v in zip(inner, start, strict=True)}
        for start in effect.starts(scales)
    )
