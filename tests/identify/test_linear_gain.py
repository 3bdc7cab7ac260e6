import pytest
from releases import drawn

from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.initial_values import scales_of
from identify.judging.linear_gain import Slope, likeliest
from identify.model.model import Term, base_model


@pytest.mark.parametrize("seed", [303, 304])
def test_a_hidden_freeplay_gains_most_at_its_own_gap(seed):
    prepared, truth = drawn("freeplay", 0.001, seed)
    slope = Slope.of(fit_baseline((prepared,), base_model()).fit)
    places = likeliest((prepared,), slope, Term(find_effect("freeplay")), scales_of(prepared, {}))
    assert places[0]["gap"] == pytest.approx(
        truth["parameters"]["gap"], rel=0.3
    )  # of places over two decades
