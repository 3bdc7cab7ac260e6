from dataclasses import replace

import numpy as np
import pytest

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.guidance import Guidance, leading, what_it_gave
from identify.effects.effect import Scales
from identify.effects.library import find_effect
from identify.fitting.initial_values import close_starts
from identify.fitting.problem import Problem
from identify.model.model import Term
from identify.planning.expected_evidence import _kept, _solve
from identify.planning.experiment import Experiment, carried_over, window_of
from identify.planning.hypotheses import hypotheses_of, odds
from identify.planning.next_release import Limits
from identify.planning.so_far import SoFar
from identify.planning.weighed_anew import weighed_anew
from identify.priors import DOUBT, RIVALS_WITHIN
from tests.identify.specimens import Specimen, among, diagnosed

LIMITS = Limits(0.002, 0.025)
SPRINGS = among("cubic_stiffness", "settling_stiffness", "time_varying_stiffness", "hysteresis", "freeplay")
DAMPERS = among("quadratic_damping", "position_dependent_damping", "fading_damping", "cubic_stiffness")


@pytest.fixture(scope="module")
def small_cubic():
    """A release from 7 mm, at which a cubic spring that shows at 20 mm is hardly there."""
    specimen = Specimen("cubic_stiffness", 0.03, 11)
    return specimen, diagnosed(specimen.release(7.0))


def test_a_refit_with_a_prior_keeps_what_least_squares_keeps():
    random = np.random.default_rng(1)
    jacobian, misfit, off = random.normal(size=(3, 40)), random.normal(size=40), random.normal(size=3)
    root = random.normal(size=(3, 3))
    # The prior as three further readings, of which least squares knows nothing else.
    rows, target = np.vstack([jacobian.T, root]), -np.concatenate([misfit, root @ off])
    left = np.linalg.lstsq(rows, target)[1][0]
    assert _kept(jacobian, root.T @ root, misfit, off) == pytest.approx(left, rel=1e-9)  # rounding


def test_what_a_record_does_not_determine_is_left_where_it_is():
    step = _solve(np.diag([4.0, 0.0]), np.array([8.0, 0.0]))
    assert step == pytest.approx([2.0, 0.0])


def test_between_shapes_of_a_spring_a_larger_amplitude_is_asked_for_and_not_the_same_again(small_cubic):
    _, found = small_cubic
    chosen = found.next_within(LIMITS)
    assert abs(chosen.best.experiment.amplitude) > 0.0071
    assert chosen.best.nats > 10.0 * chosen.same.nats
    assert chosen.words.startswith("Release from ")
    assert "The same amplitude again would give odds " in chosen.words


def test_effects_among_which_the_curves_cannot_decide_are_what_the_next_release_is_to_decide(small_cubic):
    _, found = small_cubic
    undecided = {"settling_stiffness", "hysteresis"}
    listed = hypotheses_of(found.baseline, found.suspects, (), found.final, undecided=undecided)
    assert {one.names for one in listed[:2]} == {(name,) for name in undecided}
    chances = odds(listed)
    assert chances[0] == pytest.approx(chances[1])
    assert chances[2:].sum() <= DOUBT


def test_no_release_is_asked_for_beyond_the_limits(small_cubic):
    _, found = small_cubic
    chosen = found.next_within(Limits(0.004, 0.012))
    sizes = [abs(option.experiment.amplitude) for option in chosen.options]
    assert 0.004 <= min(sizes) <= max(sizes) <= 0.012


def test_what_a_hypothesis_holds_has_no_starting_values():
    held = Term(find_effect("settling_stiffness"), {"tau": 3.0})
    scales = Scales(amplitude=0.02, frequency=25.0, duration=8.0, rate=256.0, peaks={}, lines={})
    assert set(map(str, close_starts(held, scales))) == {"{}"}


def test_the_same_choice_comes_twice(small_cubic):
    _, found = small_cubic
    first, second = found.next_within(LIMITS), found.next_within(LIMITS)
    assert (first.words, first.best) == (second.words, second.best)


def test_what_was_expected_of_a_release_is_what_it_gives():
    """The double makes the release: neither its motion nor its noise is that of the code that expects.

    What settles slowly drifts: the values that it may have lie along a valley, and end where it is named for no more.
    """
    specimen = Specimen("time_varying_stiffness", 0.015, 61)
    found = diagnose(specimen.release(7.0), library=SPRINGS)
    assert odds(found.hypotheses)[0] < 1.0 - DOUBT
    chosen = found.next_within(Limits(0.002, 0.011))
    assert chosen.between == ("time varying stiffness", "settling stiffness")
    second = specimen.release(1e3 * chosen.best.experiment.amplitude, 1)
    after = diagnose((specimen.release(7.0), second), library=SPRINGS)
    told = Guidance("go_on", chosen.words, chosen.best.experiment, chosen)
    assert what_it_gave(told, found, after) == pytest.approx(chosen.best.nats, abs=3.0 * chosen.best.scatter)
    assert chosen.best.scatter < 0.5 * chosen.best.nats
    assert odds(after.hypotheses)[0] > 1.0 - DOUBT


def test_a_record_of_its_own_costs_a_hypothesis_nothing_and_what_denies_it_much(small_cubic):
    found, experiment = small_cubic[1], Experiment(0.02)
    last, costs = found.baseline.decays[0], []
    true = next(one for one in found.hypotheses if one.names == ("cubic_stiffness",))
    usual = next(one for one in found.hypotheses if not one.names)
    window = window_of(experiment, last, true.fit.windows[0])
    own = Problem(true.fit.model, (window,), true.fit.frequency, coarse=True)
    so_far = SoFar.of(true)
    theta = own.theta(
        carried_over(experiment, last, true.fit)[0]
        | {u.name: float(t) for u, t in zip(true.fit.unknowns, so_far.theta, strict=True) if u.window < 0}
    )
    readings = own.read(theta, 0, own.respond(theta, 0))
    for one in (true, usual):
        problem = Problem(one.fit.model, (window,), one.fit.frequency, coarse=True)
        centre = problem.theta(carried_over(experiment, last, one.fit)[0])
        costs.append(SoFar.of(one).costs_more(problem, centre, readings))
    assert abs(costs[0]) < 0.5  # the gains that end its two fits
    assert costs[1] > 100.0


def test_a_free_exponent_is_open_beside_the_name_that_is_one_of_its_values():
    specimen = Specimen("quadratic_damping", 0.02, 11)
    found = diagnose((specimen.release(12.0), specimen.release(-12.0, 1)), library=DAMPERS)
    name, law = found.hypotheses[:2]
    assert (found.named, name.names) == (("quadratic_damping",), found.named)
    assert law.names == ("power_law_damping",)
    assert law.contains(name)
    assert not name.contains(law)
    assert found.next_within(LIMITS).between == (law.title, name.title)


def test_beside_what_is_named_only_what_can_still_hide_is_asked_for():
    specimen = Specimen("position_dependent_damping", 0.02, 11)
    found = diagnose((specimen.release(12.0), specimen.release(-12.0, 1)), library=DAMPERS)
    assert odds(found.hypotheses)[0] > 1.0 - DOUBT
    chosen = found.next_within(LIMITS)
    assert chosen.hidden
    assert chosen.tells_more
    assert abs(chosen.best.experiment.amplitude) == 0.025
    assert "can still hide, such as cubic stiffness" in chosen.words
    whole = diagnose((specimen.release(12.0), specimen.release(-25.0, 1)), library=DAMPERS)
    assert not whole.next_within(LIMITS).tells_more


@pytest.fixture(scope="module")
def pair():
    specimen = Specimen("cubic_stiffness+quadratic_damping", 0.02, 12)
    return diagnose(
        (specimen.release(25.0), specimen.release(-9.0, 1)),
        library=(*DAMPERS, *among("signed_quadratic_stiffness", "hysteresis")),
    )


def test_one_of_two_effects_is_exchanged_for_what_it_may_be_mistaken_for(pair):
    found = pair
    assert set(found.named) == {"cubic_stiffness", "quadratic_damping"}
    pairs = [one for one in found.hypotheses if len(one.names) == 2]
    assert len(pairs) > 1
    assert pairs[0].names == found.named
    assert all(len(set(one.names) & set(found.named)) == 1 for one in pairs[1:])


def test_of_several_effects_that_leads_which_explains_more_with_one_exchanged(pair):
    first, *others = pair.hypotheses
    exchanged = next(one for one in others if len(one.names) == 2)
    turned = replace(pair)
    vars(turned)["hypotheses"] = (replace(exchanged, log_odds=1e3), first, *others)
    assert leading(pair) == pair.named
    assert leading(turned) == exchanged.names


def test_of_two_names_of_one_law_no_release_tells_which():
    specimen = Specimen("freeplay", 0.02, 20)
    found = diagnose(
        (specimen.release(7.0), specimen.release(-15.0, 1), specimen.release(25.0, 2)),
        library=among("freeplay", "end_stop", "cubic_stiffness", "hysteresis"),
    )
    chosen = found.next_within(LIMITS)
    assert not chosen.tells_more
    assert chosen.best.nats < RIVALS_WITHIN
    assert chosen.words.startswith("No release helps: none within the limits distinguishes ")


def test_odds_agree_with_the_verdict(small_cubic):
    _, found = small_cubic
    assert odds(found.hypotheses).sum() == pytest.approx(1.0)
    whole = diagnose(
        Specimen("mains_hum", 0.02, 19).release(7.0),
        library=among("mains_hum", "harmonic_forcing", "cubic_stiffness"),
    )
    assert whole.named == ("mains_hum",)
    assert whole.hypotheses[0].names == ("mains_hum",)


def test_hypotheses_are_weighed_anew_by_a_release_that_decides(small_cubic):
    specimen, found = small_cubic
    assert odds(found.hypotheses)[0] < 0.9  # it is not decided
    first = weighed_anew(found.hypotheses, (specimen.release(7.0),), specimen.release(25.0, 1))
    assert first[0].names == ("cubic_stiffness",)
    assert odds(first)[0] > 0.99
