"""A model whose motion runs away by its first values is fitted from a linear one."""

import numpy as np
import pytest

from identify.fitting.baseline import fit_baseline
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
