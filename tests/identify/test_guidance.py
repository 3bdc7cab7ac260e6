import pytest

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.guidance import first_release, guidance
from identify.planning.next_release import Limits
from tests.identify.specimens import Specimen, among

LIMITS = Limits(0.002, 0.025)
RIVALS = among(
    "cubic_stiffness", "settling_stiffness", "time_varying_stiffness", "hysteresis", "quadratic_damping", "freeplay"
)  # fmt: skip


def diagnosed(*releases):
    return diagnose(releases, library=RIVALS)


def test_the_first_release_lies_between_the_limits():
    told = first_release(LIMITS)
    assert not told.over
    assert told.experiment is not None
    assert LIMITS.low < told.experiment.amplitude < LIMITS.high


@pytest.mark.parametrize(
    ("hidden", "strength", "seed", "state"),
    [("cubic_stiffness", 0.02, 11, "confirmed"), ("magnet", 0.02, 16, "no_name"), (None, 0.0, 13, "nothing")],
)
def test_a_test_ends_as_what_is_hidden_wants_it(hidden, strength, seed, state):
    specimen, told, decays, found = Specimen(hidden, strength, seed), first_release(LIMITS), [], None
    while not told.over:
        decays.append(specimen.release(1e3 * told.experiment.amplitude, len(decays)))
        found = diagnosed(*decays)
        told = guidance(found, len(decays), LIMITS)
        assert told.words
    assert told.state == state
    assert told.named == ((hidden,) if state == "confirmed" else ())
    assert len(decays) <= (3 if hidden else 2)  # where nothing is missing the upper limit is asked for once


def test_one_release_confirms_nothing():
    found = diagnosed(Specimen("cubic_stiffness", 0.02, 11).release(25.0))
    assert found.named == ("cubic_stiffness",)
    told = guidance(found, 1, LIMITS)
    assert not told.chosen.tells_more
    assert not told.over


def test_what_was_not_released_from_the_upper_limit_is_not_confirmed():
    specimen = Specimen("hysteresis", 0.01, 40)
    found = diagnosed(specimen.release(9.0), specimen.release(-7.0, 1))
    assert not guidance(found, 2, LIMITS).over


def test_a_law_between_the_names_is_confirmed_where_a_name_only_comes_near():
    specimen = Specimen("power_law_stiffness", 0.02, 15)
    found = diagnosed(specimen.release(7.0), specimen.release(25.0, 1))
    told = guidance(found, 2, LIMITS)
    assert (told.state, told.named) == ("confirmed", ("power_law_stiffness",))


def test_what_is_confirmed_below_the_upper_limit_says_how_far_it_was_seen():
    specimen = Specimen("cubic_stiffness", 0.02, 11)
    found = diagnosed(specimen.release(15.0), specimen.release(-15.0, 1))
    told = guidance(found, 2, LIMITS)
    assert told.over is ("could not be seen" in told.words)
    told = guidance(found, 2, Limits(0.002, 0.015))
    assert told.state == "confirmed"
    assert "could not be seen" not in told.words
