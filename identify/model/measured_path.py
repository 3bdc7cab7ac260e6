"""Along the measured motion: the forces and internal states of a fitted effect where the mass has been."""

from collections.abc import Mapping

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import STATES
from identify.model.model import Model, Term

_STEPS_BEFORE = 8
"""Steps between two samples of a motion in which a mass sets out: its velocity jumps."""


def model_force(model: Model, values: Mapping[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the force per unit mass (m/s^2) that a fitted model gives at a motion, shape (n,).

    `values` holds the parameters by "effect.parameter"; `time` (n,) is in s since the release, `u` and `v` (n,) are
    displacement from the spring's zero and velocity.
    """
    total = np.zeros(len(u))
    for term in model.forces:
        states = states_along(term, values, time, u, v)
        total += term.force.force_along(_table(term, values), time, u, v, states)
    return total


def states_along(term: Term, values: Mapping[str, float], time: Array, u: Array, v: Array) -> Array:
    """Return the internal states (n, 2) of a fitted effect driven along a motion; zeros where it has no memory."""
    first, second = (values.get(str(term.state(j)), 0.0) for j in range(STATES))
    return term.force.states_along(_table(term, values), time, u, v, (first, second))


def _table(term: Term, values: Mapping[str, float]) -> tuple[float, ...]:
    own = {p.name: float(values[str(term.parameter(p.name))]) for p in term.free}
    return term.force.table(own | term.held_values, values)


def force_along(
    term: Term,
    inner: Mapping[str, float],
    time: Array,
    u: Array,
    v: Array,
    frequency: float,
    before: tuple[Array, Array, Array] | None = None,
    *,
    off: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """Return the force per unit mass and unit strength of an effect along a motion, shape (n,).

    `inner` holds the inner parameters by their own names; shared parameters are taken at their rough values for a
    motion of angular `frequency` (rad/s). Internal states come from equilibrium at the first sample; those of a memory that
    fades from equilibrium at the first sample of the motion `before` (time, displacement, velocity) that ends there, if
    one is given: a light oscillator has turned by half a cycle while a hand lets go. They begin `off` these states.
    """
    effect = term.force
    shared = {name: roughly(frequency) for name, roughly in effect.shared_parameters.items()}
    p = effect.table({**inner, **term.held_values, effect.strength.name: 1.0}, shared)
    if before is None or effect.rates is None or not effect.fading_memory:
        begun = effect.states_at_rest(float(u[0]), p)
    else:
        rest = effect.states_at_rest(float(before[1][0]), p)
        begun = tuple(effect.states_along(p, *before, rest, steps=_STEPS_BEFORE)[-1])
    states = effect.states_along(p, time, u, v, (begun[0] + off[0], begun[1] + off[1]))
    return effect.force_along(p, time, u, v, states)
