"""Names off the floor: a force whose strength is foretold by the model's own spring needs no law of time refuted."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.off_the_floor import is_foretold
from identify.effects.library import find_effect
from identify.free_decay import FreeDecay
from identify.model.model import Term, base_model

K, MU_0, MU_1 = 120.0, 2.1, 0.2


@pytest.mark.parametrize(
    ("name", "strength", "foretold"),
    [
        ("pendulum_stiffness", 124.0, True),
        ("pendulum_stiffness", 112.0, False),
        ("pendulum_stiffness", 127.0, False),
        ("cubic_stiffness", 120.0, False),
    ],
)
def test_gravity_alone_has_the_strength_of_the_linear_spring(name: str, strength: float, foretold: bool):
    term = Term(find_effect(name))
    values = {"linear_stiffness.k": K, str(term.strength): strength}
    fit = SimpleNamespace(
        model=base_model().plus(term), parameters={n: SimpleNamespace(value=v) for n, v in values.items()}
    )
    assert is_foretold(SimpleNamespace(term=term, fit=fit)) == foretold


def swing(rate: float, seconds: float) -> np.ndarray:
    """Return the angle of k sin u with dry and viscous friction from 1.1 rad, from reversal to reversal."""

    def slope(t, y):
        return [y[1], -K * np.sin(y[0]) - MU_1 * y[1] - MU_0 * sign]

    def reversal(t, y):
        return y[1]

    reversal.terminal = True
    time = np.arange(int(rate * seconds)) / rate
    u, begin, angle = np.full(len(time), np.nan), 0.0, 1.1
    while begin < time[-1]:
        sign = -np.sign(angle)
        if K * abs(np.sin(angle)) < MU_0:
            u[time >= begin] = angle
            break
        run = solve_ivp(
            slope, (begin, begin + 3.0), [angle, 1e-9 * sign], events=reversal, dense_output=True, rtol=1e-9
        )
        inside = (time >= begin) & (time <= run.t[-1])
        u[inside] = run.sol(time[inside])[0]
        begin, angle = run.t[-1], run.y[0, -1]
    return u


@pytest.mark.slow
def test_a_pendulum_of_eight_cycles_is_named_where_a_drift_cannot_be_told_apart():
    noise = 3e-4 * np.random.default_rng(4).standard_normal(2400)
    found = diagnose(FreeDecay(500.0, displacement=swing(500.0, 4.8) + noise, unit="rad"))
    assert found.named == ("pendulum_stiffness",)
