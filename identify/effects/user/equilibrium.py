"""Memory of a user's own effect: where its internal states come to rest while the mass is held still."""

from collections.abc import Callable
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.user.expression import Node
from identify.effects.user.expression_code import over_arrays

_DRAWS = 12
_NUDGE = 1e-6
_NEWTON_STEPS = 25


def comes_to_rest(rates: tuple[Node, ...], draw: Callable[[np.random.Generator], dict[str, float]]) -> bool:
    """Whether the internal states of a mass that is held still settle by themselves, from the eigenvalues of their rates."""
    random = np.random.default_rng(2)
    for _ in range(_DRAWS):
        u, z0, z1 = random.uniform(-0.1, 0.1, 3)
        values = draw(random) | {"t": 0.0, "u": u, "v": 0.0, "z0": z0, "z1": z1}
        slopes = [[_slope(rate, values, state) for state in ("z0", "z1")[: len(rates)]] for rate in rates]
        if not np.isfinite(slopes).all():
            return False
        if not np.linalg.eigvals(np.array(slopes)).real.max() < -1e-9 * max(
            float(np.max(np.abs(slopes))), 1e-300
        ):
            return False
    return True


def _slope(rate: Node, values: dict[str, float], state: str) -> float:
    step = _NUDGE * max(abs(values[state]), 1e-3)
    above, below = (
        float(over_arrays(rate, values | {state: values[state] + way * step})) for way in (1.0, -1.0)
    )
    return (above - below) / (2.0 * step)


def rest_function(rates: Any, states: int) -> Callable[[float, Array], tuple[float, float]]:
    """Return the function (u, p) of the states at which compiled rates vanish, by Newton's method from (u, 0)."""

    def rest(u: float, p: Array) -> tuple[float, float]:
        given = (*(float(x) for x in p), *[0.0] * (PARAMETERS - len(p)))
        z = np.array([u, 0.0])
        for _ in range(_NEWTON_STEPS):
            here = np.array(rates(0.0, u, 0.0, tuple(z), given))[:states]
            slopes = np.empty((states, states))
            for j in range(states):
                step = _NUDGE * max(abs(float(z[j])), 1e-3)
                moved = z.copy()
                moved[j] += step
                slopes[:, j] = (np.array(rates(0.0, u, 0.0, tuple(moved), given))[:states] - here) / step
            if not np.isfinite(slopes).all() or abs(float(np.linalg.det(slopes))) == 0.0:
                return 0.0, 0.0
            change = np.linalg.solve(slopes, here)
            z[:states] -= change
            if float(np.max(np.abs(change))) <= 1e-12 * (1.0 + float(np.max(np.abs(z)))):
                return float(z[0]), float(z[1])
        return 0.0, 0.0

    return rest
