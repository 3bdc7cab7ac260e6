"""The operator: rest, pull, hold, release, one after another."""

import itertools

import numpy as np
import pytest

from mocks.operator_sequence import OperatorSequence, parse_releases
from mocks.testbed import Bench, Release

HANDS = itertools.repeat(0.0)


def watched(run: OperatorSequence, episodes: int) -> tuple[list, np.ndarray, np.ndarray, np.ndarray]:
    found = list(itertools.islice(run.capture(np.random.default_rng(1)), episodes))
    time = np.arange(0.0, found[-1].end, 1e-3)
    u, a = np.empty_like(time), np.empty_like(time)
    for episode in found:
        mine = (time >= episode.start) & (time < episode.end)
        u[mine], a[mine] = episode.observe(run.bench, time[mine], time[mine])
    return found, time, u, a


def test_the_mass_rests_is_pulled_held_for_a_second_and_let_go():
    episodes, time, u, a = watched(OperatorSequence(Bench(), (Release(-0.02),)), 2)
    released = episodes[0].released_at
    assert np.all(u[time < 1.0] == 0.0)
    assert np.all(a[time < 1.0] == 0.0)
    held = (time > released - 1.0) & (time < released)
    assert np.all(u[held] == -0.02)
    assert np.all(a[held] == 0.0)
    assert a[time > released][0] > 10.0
    # At rest, and at rest in the next episode; where it stopped is known to the integration's 1e-11 m.
    np.testing.assert_allclose(u[time > released + 9.0], u[-1], atol=1e-9)


def test_the_acceleration_of_the_pull_and_of_a_bump_is_the_curvature_of_the_displacement():
    episodes, time, u, a = watched(OperatorSequence(Bench(), (Release(0.025),), bumped=True), 1)
    before = time < episodes[0].released_at - 0.01
    curvature = np.gradient(np.gradient(u, 1e-3), 1e-3)
    # Second differences over 2 ms of an 18 Hz bell err by (w h)^2 / 3 of 1 m/s^2: 2 %.
    np.testing.assert_allclose(curvature[before][5:-5], a[before][5:-5], atol=0.03)
    assert np.max(np.abs(a[before])) > 0.5
    assert np.max(np.abs(a[before & (time < 2.5)])) < 0.2  # the pull itself is gentle


def test_the_next_pull_begins_where_the_mass_came_to_rest():
    run = OperatorSequence(Bench(), (Release(-0.02), Release(0.015)))
    episodes, _, u, _ = watched(run, 2)
    assert 0.0 < abs(episodes[1].rest) < 0.13 / 614.0 + 1e-9
    assert np.max(np.abs(np.diff(u))) < 0.02 * 25.0 * 1e-3 * 1.01  # no jump: at most A w0 a millisecond


def test_a_capture_begins_with_the_release_after_the_one_that_was_seen():
    run = OperatorSequence(Bench(), (Release(-0.02), Release(0.015)))
    first = next(run.capture(np.random.default_rng(1)))
    again = next(run.capture(np.random.default_rng(1)))
    assert again.number == first.number == 0  # Nothing was seen: it is still to come.
    run.use_up(first)
    second = next(run.capture(np.random.default_rng(1)))
    assert second.number == 1
    run.use_up(second)
    assert next(run.capture(np.random.default_rng(1))).number == 0


def test_the_papers_nine_releases():
    releases = parse_releases("paper", HANDS)
    assert [r.displacement for r in releases[:6]] == pytest.approx(
        [-0.025, -0.02, -0.015, -0.005, 0.02, 0.025]
    )
    assert all(r.velocity and not r.displacement for r in releases[6:])
    assert len(releases) == 9


@pytest.mark.parametrize("text", ["", "five", "20,,5", "0", "v"])
def test_a_release_that_makes_no_sense_is_refused_in_words(text):
    with pytest.raises(ValueError, match="velocity"):
        parse_releases(text, HANDS)


def test_a_struck_mass_starts_from_rest_with_the_velocity():
    episodes, time, u, _a = watched(OperatorSequence(Bench(), (Release(0.0, 0.4),)), 1)
    released = episodes[0].released_at
    assert np.all(u[time < released] == 0.0)
    soon = (time > released) & (time < released + 0.01)
    np.testing.assert_allclose(np.gradient(u[soon], 1e-3), 0.4, rtol=0.05)  # w0^2 t^2 / 2 is 3 %
