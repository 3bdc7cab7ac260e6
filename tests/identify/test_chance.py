from functools import cache

import numpy as np
import pytest
from scipy import stats
from test_fit import fitted

from identify.diagnosis.null_distribution import NullDistribution, null_distribution
from identify.effects.library import find_effect
from identify.model.model import Term

TERMS = tuple(Term(find_effect(n)) for n in ("cubic_damping", "cubic_stiffness", "quadratic_stiffness"))


@cache
def drawn_chance():
    prepared, _, found = fitted()
    return null_distribution((prepared,), found, TERMS)


@pytest.mark.parametrize("name", ["cubic_stiffness", "quadratic_stiffness"])
def test_an_effect_with_one_free_number_of_either_sign_gains_chi_square_of_one_degree(name):
    drops = drawn_chance().drops[name]
    assert stats.kstest(drops, stats.chi2(1).cdf).pvalue > 1e-3  # 1 in 1000 runs of other draws


def test_an_effect_that_can_have_one_sign_only_gains_nothing_in_half_the_draws():
    drops = drawn_chance().drops["cubic_damping"]
    # 400 draws, half of them zero: 200 with a standard deviation of 10
    assert 160 < np.sum(drops == 0.0) < 240


def test_the_larger_the_gain_the_smaller_the_odds():
    chance = drawn_chance()
    p = [chance.p_value("cubic_stiffness", drop) for drop in (0.0, 3.0, 8.0, 20.0, 60.0)]
    assert p == sorted(p, reverse=True)
    assert p[0] > 0.9
    assert p[-1] < 1e-8


def test_looking_at_more_suspects_makes_any_one_less_surprising():
    chance = drawn_chance()
    alone = NullDistribution(
        chance.drops,
        np.sort([chance.surprise("cubic_stiffness", d) for d in chance.drops["cubic_stiffness"]]),
    )
    assert chance.p_value("cubic_stiffness", 7.0) > alone.p_value("cubic_stiffness", 7.0)


def test_one_draw_in_twenty_passes_the_five_percent_level():
    chance = drawn_chance()
    passed = np.mean([np.exp(-s) for s in chance.search] < np.exp(-np.quantile(chance.search, 0.95)))
    assert passed == pytest.approx(0.05, abs=0.005)


def test_the_same_seed_gives_the_same_draws():
    prepared, _, found = fitted()
    again = null_distribution((prepared,), found, TERMS[:1])
    assert np.array_equal(again.drops["cubic_damping"], drawn_chance().drops["cubic_damping"])


def test_an_effect_that_was_not_looked_at_is_no_surprise():
    assert drawn_chance().surprise("freeplay", 100.0) == 0.0
