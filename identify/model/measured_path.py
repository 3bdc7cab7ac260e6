"""Along the measured motion: the forces and internal states of a fitted effect where the mass has been."""

from collections.abc import Mapping

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import STATES
from identify.model.model import Model, Term


def model_force(model: Model, values: Mapping[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the force per unit mass (m/s^2) that a fitted model gives at a motion, shape (n,).

    `values` holds the parameters by "effect.parameter"; `time` (n,) is in s since the release, `u` and `v` (n,) are
    displacement from the spring's zero and velocity.
    """
    total = np.zeros(len(u))
    for term in model.forces:
        total += effect_force(term, values, time, u, v)
    return total


def effect_force(term: Term, values: Mapping[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the force per unit mass of one fitted effect, shape (n,)."""
    states = states_along(term, values, time, u, v)
    return term.force.force_along(_table(term, values), time, u, v, states)


def states_along(term: Term, values: Mapping[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the internal states (n, 2) of a fitted effect driven along a motion; zeros where it has no memory."""
    first, second = (values.get(str(term.state(j)), 0.0) for j in range(STATES))
    return term.force.states_along(_table(term, values), time, u, v, (first, second))


def _table(term: Term, values: Mapping[str, float]) -> tuple[float, ...]:
    own = {p.name: float(values[str(term.parameter(p.name))]) for p in term.free}
    return term.force.table(own | term.held_values, values)


def force_along(
    term: Term, inner: Mapping[str, float], time: Array, u: Array, v: Array, frequency: float
) -> Array:
    """Return the force per unit mass and unit strength of an effect along a motion, shape (n,).

    `inner` holds the inner parameters by their own names; shared parameters are taken at their rough values for a
    motion of angular `frequency` (rad/s), internal states from equilibrium at the first sample.
    """
    effect = term.force
    shared = {name: roughly(frequency) for name, roughly in effect.shared_parameters.items()}
    p = effect.table({**inner, **term.held_values, effect.strength.name: 1.0}, shared)
    states = effect.states_along(p, time, u, v, effect.states_at_rest(float(u[0]), p))
    return effect.force_along(p, time, u, v, states)
