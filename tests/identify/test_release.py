import itertools
from pathlib import Path

import numpy as np
import pytest
from decays_in_closed_form import coulomb, exponential
from scipy.integrate import solve_ivp

from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.release import find_releases, release_of
from mocks.generate import draw
from mocks.testbed import Bench, Release, simulate

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
CHANNELS = (("displacement", "acceleration"), ("displacement",), ("acceleration",))


def pull(time: np.ndarray, to: float, hold: float, lasting: float) -> np.ndarray:
    """A displacement that a hand takes from zero to `to`, then holds for `hold` s, until t = 0."""
    s = np.clip((time + hold + lasting) / lasting, 0.0, 1.0)
    return to * s**3 * (10 - 15 * s + 6 * s**2)


@pytest.mark.parametrize("names", CHANNELS)
@pytest.mark.parametrize("hand", [0.0, 0.004, 0.012, 0.02])
def test_a_displaced_release_is_found_within_a_sample_of_the_hand_s_ramp(
    names: tuple[str, ...], hand: float
) -> None:
    for seed in range(6):
        sample = draw(None, 0.0, seed, release_time=hand)
        found = release_of(FreeDecay(256.0, **{name: getattr(sample, name) for name in names}))
        late = 0.0 if "acceleration" in names else sample.truth["displacement_late_s"]
        begun = sample.truth["released_at_s"] + late
        assert begun - 1 / 256 < found.time_s < begun + hand + 1 / 256
        assert found.kind == "displaced"
        assert found.settle / 256 > begun + hand  # the hand has surely let go
        assert found.settle / 256 < begun + hand + 0.045
        assert 150 < found.rest[1] < 256 * begun
        assert found.rest[0] == 0


@pytest.mark.parametrize("names", CHANNELS)
@pytest.mark.parametrize("rest", [0.25, 2.0])  # one cycle and eight
def test_the_hold_before_a_noisy_release_is_no_motion(names: tuple[str, ...], rest: float) -> None:
    """Noise of a twentieth of the amplitude, with thirty readings a cycle or with three hundred."""
    for seed, rate in enumerate((120.0, 400.0, 1200.0)):
        sample = draw(
            None,
            0.0,
            seed,
            amplitude=0.02,
            rate=rate,
            rest=rest,
            noise_displacement=1e-3,
            noise_acceleration=0.6,
        )
        found = release_of(FreeDecay(rate, **{name: getattr(sample, name) for name in names}))
        assert abs(found.time_s - sample.truth["released_at_s"]) < 0.05
        assert found.kind == "displaced"


@pytest.mark.parametrize("names", CHANNELS)
def test_an_impulse_is_told_from_a_displacement(names: tuple[str, ...]) -> None:
    for seed in range(6):
        sample = draw(None, 0.0, seed, amplitude=0.0, velocity=0.5, release_time=0.01)
        found = release_of(FreeDecay(256.0, **{name: getattr(sample, name) for name in names}))
        begun = sample.truth["released_at_s"]
        assert found.kind == "impulse"
        assert (
            begun - 5e-3 < found.time_s < begun + 0.01 + 5e-3
        )  # the push, a sample, and the displacement's lag


@pytest.mark.parametrize("rate", [40.0, 256.0, 2000.0, 20000.0])
@pytest.mark.parametrize("noise", [1e-4, 3e-3, 2e-2])
def test_any_rate_and_noise(rate: float, noise: float) -> None:
    time = np.arange(int(4 * rate)) / rate - 0.9 - 0.3 / rate
    u, _, a = coulomb(time, 3.944)
    rng = np.random.default_rng(int(rate))
    u = u + noise * 0.02 * rng.standard_normal(len(time))
    a = a + noise * 12.3 * rng.standard_normal(len(time))
    found = release_of(FreeDecay(rate, displacement=u, acceleration=a))
    assert abs(found.time_s - 0.9 - 0.3 / rate) < max(1 / rate, 4 * found.std_s)
    assert found.std_s < 0.01


def test_the_pull_that_displaces_the_mass_is_not_the_release() -> None:
    for lasting in (0.35, 0.8, 2.0):
        time = np.arange(1900) / 256 - 3.3021
        u, _, a = coulomb(time, 3.944)
        before = time < 0
        pulled = pull(time, 0.02, 0.25, lasting)
        u = np.where(before, pulled, u)
        a = np.where(before, np.gradient(np.gradient(pulled)) * 256**2, a)
        rng = np.random.default_rng(1)
        u, a = u + 5e-6 * rng.standard_normal(1900), a + 0.01 * rng.standard_normal(1900)
        for channels in ({"displacement": u, "acceleration": a}, {"displacement": u}, {"acceleration": a}):
            found = release_of(FreeDecay(256.0, **channels))
            assert abs(found.time_s - 3.3021) < 1 / 256
            assert len(find_releases(FreeDecay(256.0, **channels))) == 1


def test_a_bump_hum_and_spikes_are_not_the_release() -> None:
    time = np.arange(1900) / 256 - 3.3021
    u, _, a = coulomb(time, 3.944)
    rng = np.random.default_rng(2)
    bump = np.exp(-(((time + 1.7) / 0.02) ** 2)) * np.cos(150 * (time + 1.7))
    u = u + 5e-6 * rng.standard_normal(1900) + 2e-4 * bump + 1e-4 * time
    a = a + 0.01 * rng.standard_normal(1900) + 6.0 * bump + 0.06 * np.sin(2 * np.pi * 50 * time)
    u[[300, 1500]] += 0.03
    a[[420, 1200]] -= 25.0
    for channels in ({"displacement": u, "acceleration": a}, {"displacement": u}, {"acceleration": a}):
        found = find_releases(FreeDecay(256.0, **channels))
        assert len(found) == 1
        assert abs(found[0].time_s - 3.3021) < 1 / 256
        assert found[0].rest[1] - found[0].rest[0] > 100


def test_lost_samples_are_not_looked_at() -> None:
    sample = draw(None, 0.0, 5, release_time=0.0)
    valid = np.ones(len(sample.displacement), dtype=bool)
    valid[100:110] = valid[400:440] = False
    u = np.where(valid, sample.displacement, -1.0)
    found = release_of(FreeDecay(256.0, displacement=u, valid=valid))
    assert abs(found.time_s - sample.truth["released_at_s"] - sample.truth["displacement_late_s"]) < 1 / 256


@pytest.mark.parametrize("lost", [20, 34, 60])
def test_a_camera_that_loses_the_bob_for_a_while_makes_no_second_release(lost: int) -> None:
    time = np.arange(900) / 30.0
    u = 0.5 * np.exp(-0.01 * time) * np.cos(2 * np.pi * 0.9 * time)
    u += 1e-3 * np.random.default_rng(1).standard_normal(900)
    valid = np.ones(900, dtype=bool)
    valid[300 : 300 + lost] = valid[600:615] = False
    assert len(find_releases(FreeDecay(30.0, displacement=np.where(valid, u, np.nan), valid=valid))) == 1


def test_a_release_during_a_loss_is_still_a_second_one() -> None:
    time = np.arange(900) / 30.0
    again = time > 15.0
    u = 0.5 * np.exp(-0.15 * np.where(again, time - 15.0, time)) * np.cos(2 * np.pi * 0.9 * time)
    u += 1e-3 * np.random.default_rng(1).standard_normal(900)
    valid = np.abs(time - 15.0) > 0.5
    assert len(find_releases(FreeDecay(30.0, displacement=np.where(valid, u, np.nan), valid=valid))) == 2


def test_a_motion_that_is_over_at_once_is_not_called_silence() -> None:
    time = np.arange(2000) / 100.0 - 6.0
    u = np.exp(-2.5 * np.maximum(time, 0.0)) * np.sin(2 * np.pi * np.maximum(time, 0.0))
    u = u + 1e-3 * np.random.default_rng(5).standard_normal(2000)
    with pytest.raises(NotIdentifiable, match="ends within two cycles"):
        release_of(FreeDecay(100.0, acceleration=u))
    with pytest.raises(NotIdentifiable, match="above its noise"):
        release_of(FreeDecay(100.0, acceleration=1e-3 * np.random.default_rng(5).standard_normal(2000)))


def test_a_record_that_begins_in_mid_decay_says_so() -> None:
    u, _, a = exponential(np.arange(1000) / 256 + 0.2, 3.944)
    for channels in ({"displacement": u, "acceleration": a}, {"displacement": u}, {"acceleration": a}):
        found = release_of(FreeDecay(256.0, **channels))
        assert (found.kind, found.index, found.rest) == ("in_motion", 0, (0, 0))
        assert found.end > 990


@pytest.mark.parametrize(("begun", "rate"), [((1.6, 8.0), 30.0), ((2.0, 6.0), 15.0), ((2.0, 6.0), 30.0)])
def test_a_pendulum_that_swings_from_the_first_reading_is_released_there(
    begun: tuple[float, float], rate: float
) -> None:
    """So far up the period changes so much that one oscillation fits no two cycles; nothing stands still before any."""
    time = np.arange(0.0, 18.0, 1.0 / rate)
    angle = solve_ivp(
        lambda _, state: (state[1], -39.0 * np.sin(state[0]) - 0.03 * state[1]),
        (0.0, 18.0), begun, t_eval=time, rtol=1e-8, atol=1e-10,
    ).y[0]  # fmt: skip
    found = release_of(FreeDecay(rate, angle + 0.001 * np.random.default_rng(0).standard_normal(len(time))))
    assert (found.kind, found.index) == ("in_motion", 0)


def test_the_end_is_where_the_mass_sticks() -> None:
    time = np.arange(2240) / 256 - 0.75
    u = coulomb(time, 3.944)[0]
    stuck = int(np.flatnonzero(np.abs(np.diff(u)) > 0)[-1]) + 1
    u = u + 5e-6 * np.random.default_rng(3).standard_normal(2240)
    found = release_of(FreeDecay(256.0, displacement=u))
    # The last half-cycle creeps in under the noise for its last tenth.
    assert stuck - 16 < found.end < stuck + 16


def test_several_releases_in_one_file_are_all_found() -> None:
    bench, rng = Bench(), np.random.default_rng(4)
    pieces, begun, offset = [], [], 0
    for amplitude in (0.02, -0.025, 0.008):
        lasting = 3.1 + rng.random()
        time = np.arange(int((lasting + 6) * 256)) / 256 - lasting
        motion = simulate(bench, Release(displacement=amplitude), time)
        previous = pieces[-1][-1] if pieces else 0.0
        pulled = previous + pull(time, amplitude - previous, 0.8, 1.1)
        pieces.append(np.where(time < 0, pulled, motion.displacement))
        begun.append(offset / 256 + lasting)
        offset += len(time)
    u = np.concatenate(pieces) + 5e-6 * rng.standard_normal(offset)
    found = find_releases(FreeDecay(256.0, displacement=u))
    assert len(found) == 3
    for release, truth in zip(found, begun, strict=True):
        assert abs(release.time_s - truth) < 1 / 256
        assert release.kind == "displaced"
        assert release.rest[0] > (truth - 4.0) * 256 - 800
    assert all(a.end <= b.rest[1] for a, b in itertools.pairwise(found))
    assert release_of(FreeDecay(256.0, displacement=u)).time_s == found[1].time_s  # the largest


@pytest.mark.parametrize(
    ("seconds", "names"),
    [(2.6, ("displacement",)), (3.4, ("displacement", "acceleration")), (3.05, ("displacement",))],
)
def test_a_release_ends_where_a_hand_takes_the_swinging_mass_again(
    seconds: float, names: tuple[str, ...]
) -> None:
    bench, rng = Bench(mu_0=0.02), np.random.default_rng(11)
    time = np.arange(int((seconds + 2.0) * 256)) / 256
    rest = np.full(256, 0.02)
    free = simulate(bench, Release(displacement=0.02), time[time < seconds])
    start, speed = free.displacement[-1], free.velocity[-1]
    after = time[time >= seconds] - seconds
    to = 0.02 - start  # a critically damped pull from where and how the mass was moving
    fast = 1.0 / 0.05
    pulled = 0.02 - (to + (fast * to - speed) * after) * np.exp(-fast * after)
    again = simulate(bench, Release(displacement=0.02), np.arange(2000) / 256)
    u = np.concatenate([rest, free.displacement, pulled, again.displacement])
    a = np.gradient(np.gradient(u)) * 256**2
    channels = {
        "displacement": u + 5e-6 * rng.standard_normal(len(u)),
        "acceleration": a + 0.01 * rng.standard_normal(len(u)),
    }
    first, second = find_releases(FreeDecay(256.0, **{name: channels[name] for name in names}))
    taken = 256 + np.count_nonzero(time < seconds)
    assert taken - 0.4 * 65 < first.end < taken + 0.15 * 65
    assert abs(second.index - (taken + len(pulled))) < 4
    alone = release_of(FreeDecay(256.0, **{name: channels[name][: second.rest[0]] for name in names}))
    assert taken - 0.4 * 65 < alone.end < taken + 0.15 * 65


def test_noise_alone_is_refused_in_words() -> None:
    with pytest.raises(NotIdentifiable):
        release_of(FreeDecay(256.0, acceleration=0.01 * np.random.default_rng(5).standard_normal(1500)))


def test_a_ship_model_is_released_after_it_was_tilted() -> None:
    roll = np.loadtxt(EXAMPLES / "ship_roll.csv", delimiter=",", skiprows=1)[:, 1]
    found = release_of(FreeDecay(100.0, displacement=roll))
    assert 655 < found.index < 690  # the roll's second derivative turns from the hand's to the water's
    assert found.kind == "displaced"
    assert found.rest[1] - found.rest[0] > 400
    assert found.end > len(roll) - 10


def test_a_sonar_that_begins_in_motion_is_not_given_a_release() -> None:
    position = np.loadtxt(EXAMPLES / "spring_disc.csv", delimiter=";", skiprows=1)[:, 1]
    found = find_releases(FreeDecay(100.0, displacement=position))
    assert len(found) == 1
    assert found[0].kind == "in_motion"
    assert found[0].end > len(position) - 10


def let_go(hand: float, frequency: float = 40.0, rate: float = 1000.0) -> tuple[np.ndarray, float]:
    """A displacement held until 0.3 s, let go linearly within `hand` s, in closed form; and when it is free."""
    w, time = 2.0 * np.pi * frequency, np.arange(1500) / rate - 0.3
    since = np.maximum(time, 0.0)
    # a ramp of the force: u = 1 - (t - sin(w t)/w) / hand until it has ended
    after = np.maximum(since - hand, 0.0)
    u = 1.0 - (since - np.sin(w * since) / w) / hand + (after - np.sin(w * after) / w) / hand
    u = np.asarray(u) * np.exp(-0.005 * w * since)
    return 2e-4 * u + np.random.default_rng(1).normal(0.0, 2e-7, len(u)), 0.3 + hand


@pytest.mark.parametrize("hand", [0.008, 0.012, 0.020])
def test_a_hand_at_40_hz_is_waited_for(hand):
    u, free = let_go(hand)
    release = release_of(FreeDecay(1000.0, u))
    if release.kind != "in_motion":  # a slow hand lets the mass swing so little that there may be no onset
        assert release.settle / 1000.0 >= free


def beats(times: np.ndarray) -> np.ndarray:
    """Two coupled modes, one a little weaker, that damp: between the beats almost nothing moves."""
    decay = np.exp(-0.12 * times)
    return 0.03 * decay * (np.cos(2 * np.pi * 0.86 * times) + 0.93 * np.cos(2 * np.pi * 1.26 * times))


def test_a_motion_that_beats_is_one_release() -> None:
    times = np.arange(400) / 32.0
    u = np.round(beats(times) + 1e-3 * np.random.default_rng(6).standard_normal(400), 3)
    assert len(find_releases(FreeDecay(32.0, displacement=u))) == 1


@pytest.mark.parametrize("begins", [0.0, 2.0, 4.1, 18.0])
def test_a_beat_is_one_release_wherever_in_it_the_record_begins(begins: float) -> None:
    """Two pendulums joined by a spring: one that is near its node rises above what it had."""
    times = begins + np.arange(1200) / 20.0
    modes = np.cos(4.44 * times) + 0.95 * np.cos(4.79 * times + 0.4)
    u = 0.05 * modes / (1.0 + 0.01 * times) + 3e-4 * np.random.default_rng(8).standard_normal(1200)
    assert len(find_releases(FreeDecay(20.0, displacement=u))) == 1


def test_a_beat_that_rises_for_many_cycles_is_one_release() -> None:
    """Two pendulums, 0.7085 and 0.7257 Hz: the amplitude grows for twenty cycles after its node at 29 s."""
    times = np.arange(1400) / 20.0
    modes = np.cos(2.0 * np.pi * 0.7085 * times) + 0.95 * np.cos(2.0 * np.pi * 0.7257 * times)
    u = np.exp(-0.01 * times) * modes + 2e-3 * np.random.default_rng(6).standard_normal(1400)
    assert [release.end for release in find_releases(FreeDecay(20.0, u))] == [1400]


@pytest.mark.parametrize("second", [0.03, 0.08])
def test_a_second_release_is_no_beat(second: float) -> None:
    times = np.arange(1200) / 32.0
    again = np.where(times < 20.0, times, times - 20.0)
    size = np.where(times < 20.0, 0.05, second)
    held = (times > 15.0) & (times < 20.0)
    u = np.where(held, second, size * np.exp(-0.3 * again) * np.cos(2 * np.pi * 1.1 * again))
    u = u + 2e-4 * np.random.default_rng(7).standard_normal(1200)
    assert len(find_releases(FreeDecay(32.0, displacement=u))) == 2


@pytest.mark.parametrize("other", [4.8, 5.2, 5.6])
def test_a_record_that_begins_in_a_beat_begins_with_its_first_reading(other: float) -> None:
    time = np.arange(2000) / 200.0
    swing = np.exp(-0.15 * time) * 0.5 * (np.cos(8 * np.pi * time) + np.cos(2 * np.pi * other * time))
    decay = FreeDecay(200.0, displacement=swing + 1e-3 * np.random.default_rng(1).standard_normal(len(time)))
    assert find_releases(decay)[0].index == 0


def test_noise_does_not_hide_a_slow_motion() -> None:
    """A seismometer of 9 s at 10 Hz: loud at first, so that noise of 3 Hz, weighted by the frequency, stood above it."""
    times = np.arange(415) / 10.0
    rng = np.random.default_rng(8)
    u = 0.1 * np.exp(-0.06 * times) * np.cos(2 * np.pi * 0.11 * times)
    u = u + np.where(times < 5.0, 0.05, 0.004) * rng.standard_normal(415)
    found = find_releases(FreeDecay(10.0, displacement=u))
    assert len(found) == 1
    assert found[0].end > 250


def test_a_motion_after_lost_readings_begins_with_the_first_that_is_there() -> None:
    """One row at zero, nothing for two seconds, then a decay: what the gap hides is no part of the motion."""
    times = np.arange(245) / 20.0
    known = (times == 0.0) | (times > 2.2)
    u = np.where(times > 2.2, 3.6 * np.exp(-0.2 * times) * np.cos(2 * np.pi * 0.5 * (times - 2.2)), 0.0)
    u = u + 0.01 * np.random.default_rng(2).standard_normal(245)
    found = release_of(FreeDecay(20.0, displacement=np.where(known, u, np.nan), valid=known))
    assert found.end - found.settle > 150
    assert known[found.settle : found.end].all()
    assert 2.2 < found.time_s < 2.6


@pytest.mark.parametrize("gap", [(5.1, 5.7), (5.5, 6.1)])
def test_a_release_that_was_seen_is_found_before_lost_readings(gap: tuple[float, float]) -> None:
    times = np.arange(1000) / 50.0
    free = np.exp(-0.1 * (times - 5.0)) * np.cos(2 * np.pi * (times - 5.0))
    u = np.where(times < 5.0, 1.0, free) + 1e-3 * np.random.default_rng(3).standard_normal(1000)
    known = (times < gap[0]) | (times > gap[1])
    found = release_of(FreeDecay(50.0, displacement=np.where(known, u, np.nan), valid=known))
    assert found.kind == "displaced"
    assert found.time_s == pytest.approx(5.0, abs=0.03)
    assert found.rest[1] > 200


@pytest.mark.parametrize("seed", [893, 1061])
def test_a_hold_is_seen_beside_a_strongly_bent_spring(seed: int) -> None:
    """The coarse place of the release is late there, and the first swing is no part of the hold."""
    cubic = {"cubic_stiffness": {"k3": 10 ** np.random.default_rng(seed).uniform(5, 6.2)}}
    sample = draw("cubic_stiffness", 0.15, 7000 + seed, rate=100.0, parameters=cubic)
    found = release_of(FreeDecay(100.0, acceleration=sample.acceleration))
    assert found.kind == "displaced"
    assert abs(found.time_s - sample.truth["released_at_s"]) < 0.1
    assert found.rest[1] > 50
