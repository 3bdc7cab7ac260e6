import numpy as np
import pytest

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.expected_evidence import _kept, _solve
from identify.diagnosis.hypotheses import odds
from identify.diagnosis.next_release import Limits
from identify.diagnosis.weighed_anew import weighed_anew
from identify.priors import RIVALS_WITHIN
from tests.identify.specimens import Specimen

LIMITS = Limits(0.002, 0.025)


@pytest.fixture(scope="module")
def small_cubic():
    """A release from 7 mm, at which a cubic spring that shows at 20 mm is hardly there."""
    specimen = Specimen("cubic_stiffness", 0.02, 11)
    return specimen, diagnose((specimen.release(7.0),))


def pair_of(found, one, other):
    """Return half of chi-square of the first less that of the second hypothesis."""
    fits = {h.names: h.fit for h in found.hypotheses}
    return 0.5 * (fits[other,].chi_square - fits[one,].chi_square)


def test_a_refit_with_a_prior_keeps_what_least_squares_keeps():
    random = np.random.default_rng(1)
    jacobian, misfit, off = random.normal(size=(3, 40)), random.normal(size=(40, 2)), random.normal(size=3)
    root = random.normal(size=(3, 3))
    # The prior as three further readings, of which least squares knows nothing else.
    for column, kept in zip(misfit.T, _kept(jacobian, root.T @ root, misfit, off), strict=True):
        rows, target = np.vstack([jacobian.T, root]), -np.concatenate([column, root @ off])
        left = np.linalg.lstsq(rows, target)[1][0]
        assert kept == pytest.approx(left, rel=1e-9)  # rounding


def test_what_a_record_does_not_determine_is_left_where_it_is():
    step = _solve(np.diag([4.0, 0.0]), np.array([8.0, 0.0]))
    assert step == pytest.approx([2.0, 0.0])


def test_between_shapes_of_a_spring_a_larger_amplitude_is_asked_for_and_not_the_same_again(small_cubic):
    _, found = small_cubic
    chosen = found.next_within(LIMITS)
    assert abs(chosen.best.experiment.amplitude) > 0.0071
    assert chosen.best.nats > 10.0 * chosen.same.nats
    assert chosen.words.startswith("Release from ")
    assert "The same amplitude again would add " in chosen.words


def test_no_release_is_asked_for_beyond_the_limits(small_cubic):
    _, found = small_cubic
    chosen = found.next_within(Limits(0.004, 0.012))
    sizes = [abs(option.experiment.amplitude) for option in chosen.options]
    assert 0.004 <= min(sizes) <= max(sizes) <= 0.012


def test_the_same_choice_comes_twice(small_cubic):
    _, found = small_cubic
    first, second = found.next_within(LIMITS), found.next_within(LIMITS)
    assert (first.words, first.best) == (second.words, second.best)


def test_what_was_expected_of_a_release_comes_within_a_factor_of_five(small_cubic):
    """The double makes the release: neither its motion nor its noise is that of the code that expects."""
    specimen, found = small_cubic
    chosen = found.next_within(Limits(0.002, 0.012))
    after = diagnose((specimen.release(7.0), specimen.release(1e3 * chosen.best.experiment.amplitude, 1)))
    one, other = (title.replace(" ", "_") for title in chosen.between)
    right = ("cubic_stiffness", next(n for n in (one, other) if n != "cubic_stiffness"))
    gained = pair_of(after, *right) - pair_of(found, *right)
    # The shapes are 0.4 nats apart before it: what their parameters leave open is a factor of two each way.
    assert chosen.best.nats / 5.0 < gained < chosen.best.nats * 5.0


def test_of_two_names_of_one_law_no_release_tells_which():
    specimen = Specimen("freeplay", 0.02, 20)
    found = diagnose((specimen.release(7.0), specimen.release(-15.0, 1), specimen.release(25.0, 2)))
    chosen = found.next_within(LIMITS)
    assert not chosen.tells_more
    assert chosen.best.nats < RIVALS_WITHIN
    assert chosen.words.startswith("No release within the limits distinguishes ")


def test_where_nothing_is_missing_the_upper_limit_is_asked_for_once():
    specimen = Specimen(None, 0.0, 13)
    found = diagnose((specimen.release(7.0),))
    assert found.verdict == "nothing_missing"
    chosen = found.next_within(LIMITS)
    assert chosen.tells_more
    assert abs(chosen.best.experiment.amplitude) > 0.0071
    again = diagnose((specimen.release(7.0), specimen.release(25.0, 1)))
    assert not again.next_within(LIMITS).tells_more


def test_odds_agree_with_the_verdict(small_cubic):
    _, found = small_cubic
    assert odds(found.hypotheses).sum() == pytest.approx(1.0)
    whole = diagnose((Specimen("mains_hum", 0.02, 19).release(7.0),))
    assert whole.named == ("mains_hum",)
    assert whole.hypotheses[0].names == ("mains_hum",)


def test_hypotheses_are_weighed_anew_by_a_release_that_decides(small_cubic):
    specimen, found = small_cubic
    assert found.hypotheses[0].names != ("cubic_stiffness",)  # it is not decided
    first = weighed_anew(found.hypotheses, (specimen.release(7.0),), specimen.release(25.0, 1))
    assert first[0].names == ("cubic_stiffness",)
    assert odds(first)[0] > 0.99
