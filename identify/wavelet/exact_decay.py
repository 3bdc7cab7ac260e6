"""The exact decay of one mass under stiffness and damping of every order, from reversal to reversal."""

from math import ceil, pi, sqrt

import numpy as np

from identify.arrays import Array
from identify.effects.families import POWER_LAW_DAMPING
from identify.effects.library import DAMPING_BY_ORDER, STIFFNESS_BY_ORDER
from identify.errors import NotIdentifiable
from identify.model.simulate import Response, make_system, simulate

_STEPS_PER_CYCLE = 100  # the frequency of a fourth-order step is then off by some 1e-8


_RUN_AWAY = 100.0  # times the first amplitude: no free decay grows so far


class RunsAway(NotIdentifiable):
    """The coefficients describe no free decay: the motion grows without end, or is no number at all."""

    def __init__(self) -> None:
        super().__init__(
            "with the stiffness and the damping of the envelope the motion would diverge; "
            "release from a smaller amplitude, or try lower orders"
        )


def simulate_decay(
    displacement: float, velocity: float, stiffness: dict[int, float], damping: Array, step: float, count: int
) -> Response:
    """Simulate u'' = -sum k_i u^i - sum mu_i |u'|^i sgn(u') from a given state; `count` samples `step` s apart.

    `stiffness` holds k_i (per unit mass) by its order i: 1, 3 and 5; `damping` mu_0, mu_1, .... The mass sticks where
    the spring cannot overcome mu_0. Raises RunsAway where a coefficient is no finite number, k_1 lets the mass
    turn more than once between two samples, or the motion grows to a hundred times its start.
    """
    turn = step * sqrt(max(abs(stiffness[1]), 1e-300))
    if not np.isfinite([displacement, velocity, *stiffness.values(), *damping]).all() or turn > 2 * pi:
        raise RunsAway
    higher = [(STIFFNESS_BY_ORDER[i], k, i) for i, k in stiffness.items() if i > 1]
    higher += [
        (DAMPING_BY_ORDER[i] if i < len(DAMPING_BY_ORDER) else POWER_LAW_DAMPING.effect, mu, i)
        for i, mu in enumerate(damping)
        if i > 1
    ]
    mu_0, mu_1 = [*damping, 0.0][:2]
    motion = simulate(
        make_system(tuple(effect for effect, _, _ in higher)),
        np.array([stiffness[1], mu_1, mu_0]),
        np.array([(size, order, 1.0, 0.0, 0.0, 0.0) for _, size, order in higher]).reshape(-1, 6),
        start=(displacement, velocity),
        states=np.zeros((len(higher), 2)),
        samples=count,
        rate=1.0 / step,
        substeps=max(1, ceil(_STEPS_PER_CYCLE * turn / (2 * pi))),
    )
    start = max(abs(displacement), abs(velocity) * step / turn)
    if not np.abs(motion.displacement).max(initial=0.0) <= _RUN_AWAY * start:
        raise RunsAway
    return motion
