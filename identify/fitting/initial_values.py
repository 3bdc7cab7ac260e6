"""Starting values of a fit: strengths by equation error, inner parameters by the effects' rules, states by the motion."""

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Scales, Starts, with_midpoints
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.model.parameter_id import ParameterId, nuisance, values_in_release
from identify.preprocessing.equation_error import Regression, moving, regress
from identify.preprocessing.fit_window import release_numbers
from identify.preprocessing.prepared_decay import PreparedDecay


def initial_values(
    decays: tuple[PreparedDecay, ...], model: Model, inner: dict[str, float]
) -> dict[str, float]:
    """Estimate starting values by unknown's name: strengths by equation error, states from the motions.

    `inner` gives inner parameters by "effect.parameter". The strengths share all releases, whose zeros are their own.
    """
    values = dict(inner)
    for term, strength in zip(model.forces, _strengths(decays, model, inner), strict=True):
        values[str(term.strength)] = float(strength)
    return values | initial_nuisances(decays, model, inner)


def initial_nuisances(
    decays: tuple[PreparedDecay, ...], model: Model, inner: dict[str, float]
) -> dict[str, float]:
    """Estimate starting values of the releases' own unknowns, by name: states, lag, gain, offsets."""
    values: dict[str, float] = {}
    if any(prepared.window.estimates_mass for prepared in decays):
        values[str(nuisance("force_gain"))] = 1.0
    numbers, _ = release_numbers([prepared.window for prepared in decays])
    for i, prepared in enumerate(decays):
        own = _of_release(prepared, model.forces, values_in_release(inner, numbers[i]))
        values |= {str(id.of_release(i, len(decays))): value for id, value in own.items()}
    return values


def rest_states(
    term: Term, displacement: float, velocity: float, inner: dict[str, float]
) -> dict[ParameterId, float]:
    """Estimate the internal states of an effect with memory soon after the release, as if it were the only release."""
    effect = term.force
    if not effect.states:
        return {}
    values = {effect.strength.name: 0.0} | inner_values(term, inner)
    p = np.array([values[parameter.name] for parameter in effect.parameters])
    first, second = effect.states_at_rest(displacement, p)
    return {term.state(j): state for j, state in enumerate((first, second or velocity)[: effect.states])}


def inner_values(term: Term, inner: dict[str, float]) -> dict[str, float]:
    """Return the inner parameters of a force by their own names: those that are held, others from `inner` by full name."""
    given = {p.name: inner[str(term.parameter(p.name))] for p in term.free if p.name in term.effect.inner}
    return given | term.held_values


def _of_release(
    prepared: PreparedDecay, terms: tuple[Term, ...], inner: dict[str, float]
) -> dict[ParameterId, float]:
    """Estimate the state, lag, gain and offsets of one release, as if it were the only one."""
    motion, window = prepared.motion, prepared.window
    u, v = float(motion.displacement[0]), float(motion.velocity[0])
    values = {"displacement": u, "velocity": v, "lag": window.lag, "gain": window.gain}
    if "displacement" in window.readings:
        values["displacement_offset"] = prepared.zero
    if "acceleration" in window.readings:
        used = window.used["acceleration"]
        values["acceleration_offset"] = float(
            np.median((window.readings["acceleration"] - window.gain * motion.acceleration)[used])
        )
    found = {nuisance(name): value for name, value in values.items()}
    for term in terms:
        found |= rest_states(term, u, v, inner)
    return found


def _strengths(decays: tuple[PreparedDecay, ...], model: Model, inner: dict[str, float]) -> Array:
    """Estimate the strengths of a model's forces by equation error over all releases, (forces,), within their bounds.

    One that would leave its bounds is held there and the others are found anew: a dry friction that came out negative
    and was only cut off would leave the viscous damping twice too large.
    """
    numbers, _ = release_numbers([prepared.window for prepared in decays])
    rows = [
        _rows(one, model, values_in_release(inner, number))
        for one, number in zip(decays, numbers, strict=True)
    ]
    design, restoring = np.vstack([d for d, _ in rows]), np.concatenate([r for _, r in rows])
    low, high = np.full(design.shape[1], -np.inf), np.full(design.shape[1], np.inf)
    for i, term in enumerate(model.forces):
        low[i], high[i] = term.effect.strength.low, term.effect.strength.high
    size = np.linalg.norm(design, axis=0)
    if not len(design) or not np.isfinite(size).all():  # nothing moves, or a state diverged
        return np.clip(np.zeros(len(model.forces)), low[: len(model.forces)], high[: len(model.forces)])
    size[size == 0.0] = 1.0
    found, free = np.zeros(design.shape[1]), np.ones(design.shape[1], dtype=bool)
    while free.any():
        left = restoring - design[:, ~free] @ found[~free]
        found[free] = np.linalg.lstsq((design / size)[:, free], left, rcond=None)[0] / size[free]
        out = free & ((found < low) | (found > high))
        if not out.any():
            break
        found, free = np.clip(found, low, high), free & ~out
    return found[: len(model.forces)]


def _rows(prepared: PreparedDecay, model: Model, inner: dict[str, float]) -> tuple[Array, Array]:
    """Return forces of unit strength (m, forces) and restoring force (m,) where it moves, in units of the noise.

    Both without their means, which leaves a release its own zero.
    """
    motion, used = prepared.motion, moving(prepared.motion)
    columns = _force_columns(prepared, model, inner)[used]
    restoring = prepared.restoring[used]
    noise = motion.noise_acceleration or 1.0
    if not used.any() or not np.isfinite(columns).all():
        return columns, restoring
    return (columns - columns.mean(axis=0)) / noise, (restoring - restoring.mean()) / noise


def _force_columns(prepared: PreparedDecay, model: Model, inner: dict[str, float]) -> Array:
    """Return forces of unit strength along the measured motion, (n, forces), at inner parameters by full name.

    Where the mass was only estimated, a last column is the external force's.
    """
    motion = prepared.motion
    along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
    held = prepared.window.pre_release
    before = None if held is None else (held.time, held.displacement, held.velocity)
    columns = [
        prepared.window.lightness * force_along(term, inner_values(term, inner), *along, before)
        for term in model.forces
    ]
    if prepared.window.estimates_mass:
        assert prepared.window.force is not None
        columns.append(-prepared.window.force)
    return np.column_stack(columns)


def regress_model(prepared: PreparedDecay, model: Model, inner: dict[str, float]) -> Regression:
    """Regress the measured restoring force on the forces of a model at given inner parameters.

    Where the mass was only estimated, what the external force should be corrected by is regressed too.
    """
    motion, columns = prepared.motion, _force_columns(prepared, model, inner)
    return regress(prepared.restoring, columns, moving(motion), motion.noise_acceleration or 1.0)


def regress_states(
    prepared: PreparedDecay, model: Model, inner: dict[str, float], term: Term
) -> tuple[Regression, Array]:
    """Regress the restoring force on a model's forces, and on what one of them adds if its memory did not begin at rest.

    With the regression comes how far off rest it began, (states,): its force is linear in that, as in its strength.
    """
    motion, columns = prepared.motion, _force_columns(prepared, model, inner)
    place, effect = model.forces.index(term), term.force
    along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
    first, second = effect.state_sizes(prepared.amplitude, prepared.frequency)
    offs = ((first, 0.0), (0.0, second))[: effect.states]
    begun = [
        prepared.window.lightness * force_along(term, inner_values(term, inner), *along, off=off)
        - columns[:, place]
        for off in offs
    ]
    noise = motion.noise_acceleration or 1.0
    found = regress(prepared.restoring, np.column_stack([columns, *begun]), moving(motion), noise)
    strength = found.strengths[place] or np.inf
    return found, found.strengths[columns.shape[1] :] / strength * (first, second)[: effect.states]


def scales_of(prepared: PreparedDecay, lines: dict[str, tuple[tuple[float, float, float], ...]]) -> Scales:
    """Collect the sizes from which effects take their starting values."""
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
    """List the starting values of a term's inner parameters by their own names; for a fault, of all its parameters."""
    return _named(term, term.effect.starting_values(scales, term.channel))


def starts_between(term: Term, scales: Scales, times: int) -> tuple[dict[str, float], ...]:
    """List the same with a place between each two neighbouring ones, added so many times."""
    starts = term.effect.starting_values(scales, term.channel)
    for _ in range(times):
        starts = with_midpoints(starts)
    return _named(term, starts)


def close_starts(term: Term, scales: Scales) -> tuple[dict[str, float], ...]:
    """List the same, close together over the whole range of a fit."""
    return _named(term, term.effect.close_starting_values(scales, term.channel))


def _named(term: Term, starts: Starts) -> tuple[dict[str, float], ...]:
    effect = term.effect
    in_variants = {key for variant in effect.variants for key in variant}
    started = effect.parameters[1:] if term.is_force else effect.parameters
    names = [p.name for p in started if p.name not in in_variants]
    each = (zip(names, start, strict=True) for start in starts)
    return tuple({name: value for name, value in one if name not in term.held} for one in each)
