from functools import cache

import numpy as np
import pytest
from releases import drawn
from scipy import stats
from test_fit import fitted

from identify.diagnosis import null_forces as module
from identify.diagnosis.null_distribution import NullDistribution, drawn_noise, null_distribution, seed_of
from identify.diagnosis.weak_presence import probes
from identify.effects.effect import Scales
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from identify.fitting.initial_values import initial_values
from identify.fitting.problem import Problem
from identify.fitting.segments import segments_of
from identify.free_decay import FreeDecay
from identify.model.model import Term, base_model
from identify.preprocessing.prepared_decay import prepare

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


def noise_beside(factor):
    """Return the noise that is drawn beside the readings of a fit times a factor."""
    window = fitted()[2].windows[0]
    changed = window.with_(readings={c: factor * r for c, r in window.readings.items()})
    return drawn_noise(changed, seed_of(changed), 20)


def test_readings_that_differ_by_rounding_get_the_same_draws_and_other_readings_others():
    assert np.array_equal(noise_beside(1.0 + 1e-12), noise_beside(1.0))
    assert not np.allclose(noise_beside(1.001), noise_beside(1.0))


def test_a_record_turned_over_gets_its_draws_turned_over():
    assert np.array_equal(noise_beside(-1.0), -noise_beside(1.0))


def test_a_stop_is_drawn_on_either_side_where_a_cycle_has_many_readings():
    """Of 0.5 Hz at 400 Hz, let go at one side, two hundred readings do not reach the other."""
    time = np.arange(3200) / 400.0
    u = 0.02 * np.exp(-0.1 * time) * np.cos(np.pi * time)
    prepared = prepare(
        FreeDecay(400.0, displacement=u + 5e-6 * np.random.default_rng(1).standard_normal(3200))
    )
    found = fit_baseline((prepared,), base_model()).fit
    for side in (1.0, -1.0):
        stop = (Term(find_effect("end_stop"), held={"side": side}),)
        drops = null_distribution((prepared,), found, stop, draws=60).drops["end_stop"]
        assert np.mean(drops > 0.0) > 0.5


def test_a_fault_of_each_of_several_releases_gains_chi_square_of_its_own_parameters_in_each():
    """Two numbers in each of two releases: what parameters of both follow of one release they follow in part."""
    decays = segments_of([drawn(None, 0.0, seed)[0] for seed in (7100, 7101)])
    found = fit_baseline(decays, base_model()).fit
    bent = (Term(find_effect("sensor_nonlinearity"), held={"channel": "displacement"}),)
    drops = null_distribution(decays, found, bent, seed=3, draws=800).drops["sensor_nonlinearity"]
    # 800 draws of a chi-square of 4 degrees: a mean of 4 with a standard deviation of 0.1
    assert np.mean(drops) == pytest.approx(4.0, abs=0.35)


def test_a_joint_held_on_the_other_side_leaves_the_joints_of_the_model_where_they_are():
    prepared, _ = drawn("dahl_friction", 0.03, 7100)
    dahl, hysteresis = Term(find_effect("dahl_friction")), Term(find_effect("hysteresis"))
    model = base_model().plus(dahl)
    start = initial_values((prepared,), model, dahl.by_name({"ud": 1e-3}))
    found = fit(model, (prepared.window,), start, prepared.frequency)
    problem = Problem(model.plus(hysteresis), found.windows, found.frequency)
    before = Problem(model, found.windows, found.frequency).residuals(found.theta)
    points = probes((prepared,), found, problem, hysteresis, {"uy": 3e-3}, 1e-5)
    columns = module._held_either_way(problem, hysteresis, points, before)
    # the state begins at 3 mm at most of 20 mm and 30 cycles: it changes little of what the force does
    assert max(map(np.linalg.norm, columns)) < 1.5 * min(map(np.linalg.norm, columns))


@pytest.mark.parametrize("spread", [0.5, 1.0])
def test_the_larger_the_gain_the_smaller_the_odds_of_draws_with_a_heavy_tail(spread):
    """Degrees of freedom cannot tell the tail of noise of unknown strength."""
    random = np.random.default_rng(0)
    draws = np.sort(
        stats.chi2(5).rvs(400, random_state=random) * (1.0 + spread * random.standard_normal(400)) ** 2
    )
    surprises = [
        NullDistribution({"fault": draws}, draws).surprise("fault", x) for x in np.linspace(0.0, 99.0, 200)
    ]
    assert surprises == sorted(surprises)


@pytest.mark.parametrize("degrees", [1, 3, 9, 20])
def test_the_tail_of_what_many_releases_have_each_for_itself_is_that_of_their_sum(degrees):
    draws = np.sort(stats.chi2(degrees).rvs(400, random_state=np.random.default_rng(5)))
    chance = NullDistribution({"fault": draws}, draws)
    for tail in (1e-2, 1e-3, 1e-4):
        # the last tenth of 400 draws gives its mean to 16 %; a slope of 1/2 gives 13 for 9.2 at 20 degrees
        found = chance.surprise("fault", float(stats.chi2(degrees).isf(tail)))
        assert found == pytest.approx(-np.log(tail), rel=0.2)


def test_an_effect_that_was_not_looked_at_is_no_surprise():
    assert drawn_chance().surprise("freeplay", 100.0) == 0.0


@cache
def chance_of_three():
    decays = tuple(drawn(None, 0.0, seed)[0] for seed in (310, 311, 312))
    found = fit_baseline(decays, base_model()).fit
    terms = [Term(find_effect("cubic_stiffness"))]
    for name, channel in (("offset_drift", "displacement"), ("mains_hum", "displacement")):
        terms.append(Term(find_effect(name), {"channel": channel}))
    terms.append(Term(find_effect("harmonic_forcing")))
    return null_distribution(decays, found, tuple(terms))


def test_a_force_of_three_releases_has_one_strength_and_a_sensors_drift_three():
    drops = chance_of_three().drops
    assert stats.kstest(drops["cubic_stiffness"], stats.chi2(1).cdf).pvalue > 1e-3  # 1 in 1000 runs
    assert stats.kstest(drops["offset_drift"], stats.chi2(3).cdf).pvalue > 1e-3  # of either sign in each


def test_lines_of_a_sensor_add_up_over_releases_and_that_of_a_force_is_one():
    # The largest of m exponential powers of mean 2 lies near 2 ln m; between the bins some 1.5 times as many are seen.
    window = fitted()[0].window
    one = 2.0 * np.log(1.5 * len(window) / 2.0) + 2.0 * 0.5772
    drops = chance_of_three().drops
    assert np.mean(drops["mains_hum"]) == pytest.approx(3.0 * one, rel=0.06)
    assert np.mean(drops["harmonic_forcing"]) == pytest.approx(one, rel=0.12)


def test_an_unsure_floor_makes_large_gains_less_surprising():
    """Noise that is stronger by 1 + 0.4 z, z normal, has 1 + 0.4^2 times the mean gain, and a longer tail."""
    prepared, _, found = fitted()
    unsure = (dict.fromkeys(found.windows[0].channels, 0.4),)
    drops = null_distribution((prepared,), found, TERMS[1:2], unsure=unsure).drops["cubic_stiffness"]
    sure = drawn_chance().drops["cubic_stiffness"]
    assert np.mean(drops) == pytest.approx(
        1.16, abs=0.35
    )  # of 400 draws with a standard deviation of 2.3, three errors
    assert np.quantile(drops, 0.98) > np.quantile(sure, 0.98)


def test_chance_draws_a_second_mass_wherever_it_is_searched():
    scales = Scales(
        amplitude=0.02,
        frequency=24.8,
        duration=4.0,
        rate=256.0,
        peaks={},
        lines={"displacement": ((90.0, 1.0, 0.0),)},
    )
    searched = [start[0] for start in find_effect("second_mass").starting_values(scales)]
    drawn_at = sorted({start[0] for start in find_effect("second_mass").reachable_starting_values(scales)})
    assert drawn_at[0] <= min(searched)
    assert drawn_at[-1] >= max(searched)
    # along frequency, what noise of T seconds has in common with a tone has no period below 2 pi / T: two values a period
    assert np.max(np.diff(drawn_at)) < np.pi / 4.0
