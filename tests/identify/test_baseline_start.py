"""A model whose motion runs away by its first values, or is stopped by friction, is fitted from a linear one."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from identify.fitting.baseline import fit_baseline
from identify.fitting.model_error import motion_percent
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import model_of_orders
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("seed", [3, 4])
def test_a_model_that_would_run_away_is_fitted_from_a_linear_one(seed: int) -> None:
    sample = draw(None, 0.0, seed)
    decays = segments_of(prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration)))
    model = model_of_orders(1, (1, 3, 5))
    bad = {"linear_stiffness.k": 530.0, "cubic_stiffness.k3": 1.6e6, "quintic_stiffness.k5": -9.5e9}
    start = fit_baseline(decays, model).fit.point | bad | {"displacement": 0.04}
    found = fit_baseline(decays, model, start).fit
    assert np.isfinite(found.chi_square)
    assert found.reduced < 2.0


@pytest.mark.parametrize("seed", [129, 169])
def test_friction_that_stops_the_motion_too_early_is_not_where_the_fit_ends(seed: int) -> None:
    """A plate on a pendulum in 15 s at 10 Hz: by equation error friction stops it, and from there no step leads out."""
    draws = np.random.default_rng(seed)
    drag, viscous, softening, largest = (
        draws.uniform(*of) for of in ((0.5, 3), (0, 0.05), (0, 40), (0.1, 0.35))
    )

    def moves(_: float, state: np.ndarray) -> list[float]:
        u, v = state
        return [v, -9.36 * u + softening * u**3 - viscous * v - drag * v * abs(v)]

    time = np.arange(150) / 10.0
    motion = solve_ivp(moves, (0, time[-1]), [largest, 0.0], t_eval=time, rtol=1e-7, atol=1e-9).y[0]
    noise = 3.0 * draws.choice([0.002, 0.006, 0.01]) * largest * draws.standard_normal(150)
    decays = segments_of(prepare(FreeDecay(10.0, motion + noise)))
    usual = model_of_orders(1, (1,))
    found = fit_baseline(decays, usual).fit
    near = fit_baseline(decays, usual, found.point | {"coulomb_friction.mu_0": 0.0}).fit
    assert motion_percent(found) < 1.2 * motion_percent(near)
    assert found.values["coulomb_friction.mu_0"].value < 0.02
