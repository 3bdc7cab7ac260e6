"""The exact stick-slip decay of one mass, with springs and damping of any order, that a ridge is compared with."""

from math import pi, sqrt

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import address_of_force, force_function
from identify.errors import NotIdentifiable
from identify.model.simulate import Response, System, simulate, substeps_for

MOST_DAMPING = 5
"""Highest order of damping."""

_RUN_AWAY = 100.0  # times the first amplitude: no free decay grows so far


class RunsAway(NotIdentifiable):
    """The coefficients describe no free decay: the motion grows without end, or is no number at all."""

    def __init__(self) -> None:
        super().__init__(
            "the stiffness and the damping that the envelope shows would let the motion run away; "
            "release from a smaller amplitude, or try lower orders"
        )


@force_function
def _springs(t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Springs of the third and the fifth order."""
    return u * u * u * (p[0] + p[1] * u * u)


@force_function
def _damping(t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Damping of the orders 2 to 5, and dry friction that pushes: the simulator knows none below zero."""
    speed = abs(v)
    push = p[4] * np.sign(v)
    return speed * v * (p[0] + speed * (p[1] + speed * (p[2] + speed * p[3]))) + push


@force_function
def _no_friction(t, u, v, z, p):  # type: ignore[no-untyped-def]
    """A level that is zero: with it the simulator stops at every reversal."""
    return 0.0


def simulate_decay(
    displacement: float, velocity: float, stiffness: Array, damping: Array, step: float, count: int
) -> Response:
    """Integrate u'' = -sum k_i u^i - sgn(u') sum mu_i |u'|^i from a given state; `count` samples `step` s apart.

    `stiffness` holds k_1, ... k_5 (per unit mass, those of even order zero), `damping` mu_0, ... mu_5, or fewer of each.
    Raises RunsAway where a coefficient is no finite number, k_1 lets the mass turn more than once between two
    samples, or the motion grows to a hundred times its start.
    """
    turn = step * sqrt(max(abs(stiffness[0]), 1e-300))
    given = np.concatenate([[displacement, velocity], stiffness, damping])
    if not np.isfinite(given).all() or turn > 2 * pi:
        raise RunsAway
    k, mu, table = np.zeros(5), np.zeros(MOST_DAMPING + 1), np.zeros((2, 6))
    k[: len(stiffness)], mu[: len(damping)] = stiffness, damping
    table[0, :2], table[1, :5] = k[2::2], [*mu[2:], min(mu[0], 0.0)]
    resisting, at_reversals = address_of_force(_damping), address_of_force(_no_friction)
    addresses = np.array([[address_of_force(_springs), 0, 0], [resisting, at_reversals, 0]])
    found = simulate(
        System(addresses, nonsmooth=False),
        np.array([k[0], mu[1], max(mu[0], 0.0)]),
        table,
        start=(displacement, velocity),
        states=np.zeros((2, 2)),
        samples=count,
        rate=1.0 / step,
        substeps=substeps_for(turn / step, 1.0 / step, nonsmooth=False),
    )
    start = max(abs(displacement), abs(velocity) * step / turn)
    if not np.abs(found.displacement).max(initial=0.0) <= _RUN_AWAY * start:
        raise RunsAway
    return found
