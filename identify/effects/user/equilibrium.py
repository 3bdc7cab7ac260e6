"""Memory of a user's own effect: where its internal states come to rest while the mass is held still."""

from collections.abc import Callable
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.user.linearity import Draw

_DRAWS = 12
_NUDGE = 1e-6
_NEWTON_STEPS = 25


def comes_to_rest(rates: Any, states: int, draw: Draw) -> bool:
    """Check by the eigenvalues of their rates whether the internal states settle while the mass is held still."""
    random = np.random.default_rng(2)
    for _ in range(_DRAWS):
        u, *z = random.uniform(-0.1, 0.1, 3)
        slopes = _slopes(rates, states, u, np.array(z), _padded(np.array(list(draw(random).values()))))
        if not np.isfinite(slopes).all():
            return False
        if not np.linalg.eigvals(slopes).real.max() < -1e-9 * max(float(np.max(np.abs(slopes))), 1e-300):
            return False
    return True


def rest_function(rates: Any, states: int) -> Callable[[float, Array], tuple[float, float]]:
    """Return the function (u, p) of the states at which compiled rates vanish, by Newton's method from (u, 0)."""

    def rest(u: float, p: Array) -> tuple[float, float]:
        given = _padded(p)
        z = np.array([u, 0.0])
        for _ in range(_NEWTON_STEPS):
            slopes = _slopes(rates, states, u, z, given)
            if not np.isfinite(slopes).all() or abs(float(np.linalg.det(slopes))) == 0.0:
                return 0.0, 0.0
            change = np.linalg.solve(slopes, _rates(rates, states, u, z, given))
            z[:states] -= change
            if float(np.max(np.abs(change))) <= 1e-12 * (1.0 + float(np.max(np.abs(z)))):
                return float(z[0]), float(z[1])
        return 0.0, 0.0

    return rest


def _padded(p: Array) -> tuple[float, ...]:
    return (*(float(x) for x in p), *[0.0] * (PARAMETERS - len(p)))


def _rates(rates: Any, states: int, u: float, z: Array, p: tuple[float, ...]) -> Array:
    return np.array(rates(0.0, u, 0.0, (float(z[0]), float(z[1])), p))[:states]


def _slopes(rates: Any, states: int, u: float, z: Array, p: tuple[float, ...]) -> Array:
    """Differentiate the rates by the states, (states, states)."""
    slopes = np.empty((states, states))
    for j in range(states):
        step = np.zeros(2)
        step[j] = _NUDGE * max(abs(float(z[j])), 1e-3)
        above, below = (_rates(rates, states, u, z + way * step, p) for way in (1.0, -1.0))
        slopes[:, j] = (above - below) / (2.0 * step[j])
    return slopes
