"""Memory of a user's own effect: where its internal states come to rest while the mass is held still."""

from collections.abc import Callable
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import PARAMETERS
from identify.effects.user.linearity import Draw

_DRAWS = 12


def comes_to_rest(rates: Any, states: int, draw: Draw) -> bool:
    """Check by the eigenvalues of their rates whether the internal states settle while the mass is held still."""
    from scipy.optimize import approx_fprime  # loaded when it is needed

    random = np.random.default_rng(2)
    for _ in range(_DRAWS):
        u, *z = random.uniform(-0.1, 0.1, 3)
        held = _rates_at(rates, states, u, np.array(list(draw(random).values())))
        slopes = np.reshape(approx_fprime(np.array(z[:states]), held), (states, states))
        if not np.isfinite(slopes).all():
            return False
        if not np.linalg.eigvals(slopes).real.max() < -1e-6 * max(float(np.max(np.abs(slopes))), 1e-300):
            return False
    return True


def rest_function(rates: Any, states: int) -> Callable[[float, Array], tuple[float, float]]:
    """Return the function (u, p) of the states at which compiled rates vanish, sought from (u, 0); zeros without any."""
    from scipy.optimize import root  # loaded when it is needed

    def rest(u: float, p: Array) -> tuple[float, float]:
        found = root(_rates_at(rates, states, u, p), [u, 0.0][:states], tol=1e-12)
        z = [*found.x, 0.0] if found.success else [0.0, 0.0]
        return float(z[0]), float(z[1])

    return rest


def _rates_at(rates: Any, states: int, u: float, p: Array) -> Callable[[Array], Array]:
    """Return the rates (states,) of the states at a displacement and at parameters."""
    given = (*(float(x) for x in p), *[0.0] * (PARAMETERS - len(p)))

    def at(z: Array) -> Array:
        first, second = (*(float(x) for x in z), 0.0)[:2]
        return np.array(rates(0.0, u, 0.0, (first, second), given))[:states]

    return at
