from collections.abc import Callable

import numpy as np
import pytest
from scripted_board import AMPLITUDE, DECAY, NOISE_A, NOISE_X, OMEGA, RATE, decay

from daq.recording import Channel
from daq.trigger import RestPeriod, Trigger, Triggered

X = Channel("x", "displacement", "m", 1e-6, -0.05, 0.05)
A = Channel("a", "acceleration", "m/s^2", 1e-3, -50.0, 50.0)
BOTH = (X, A)


def watch(samples: np.ndarray, channels: tuple[Channel, ...] = BOTH, block: int = 16) -> Triggered | None:
    """Feed samples as they would come, from rest to trigger."""
    period, trigger = RestPeriod(channels, RATE, 0.5), None
    for first in range(0, samples.shape[1], block):
        part = samples[:, first : first + block]
        if not period.complete:
            period.feed(part)
        if trigger is None and period.noise is not None:
            trigger = Trigger(channels, RATE, period.noise, again(samples))
        if trigger is not None:
            found = trigger.feed(first, part)
            if found is not None:
                return found
    return None


def again(samples: np.ndarray) -> Callable[[int, int], np.ndarray]:
    """Samples that came, by their indices."""
    return lambda first, stop: samples[:, first:stop]


def noise(n: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(2, n)) * np.array([[NOISE_X], [NOISE_A]])


def moved(path: np.ndarray, seed: int = 0) -> np.ndarray:
    """Both channels of a mass that follows `path` (m), with noise."""
    a = np.gradient(np.gradient(path, 1 / RATE), 1 / RATE)
    return np.array([path, a]) + noise(len(path), seed)


def pull(n: int, start: int, seconds: float, to: float = AMPLITUDE) -> np.ndarray:
    """A smooth pull from 0 to `to`, in m."""
    u = np.clip((np.arange(n) - start) / (seconds * RATE), 0, 1)
    return to * (10 * u**3 - 15 * u**4 + 6 * u**5)


@pytest.mark.parametrize("fraction", [0.0, 0.3, 0.6, 0.9])
@pytest.mark.parametrize("seed", range(5))
def test_an_ideal_release_is_found_within_one_sample(fraction: float, seed: int) -> None:
    release = 400 + fraction
    found = watch(decay(1400, release, seed))
    assert found is not None
    assert 0 <= found.sample - release <= 1.0


def test_it_finds_the_half_period() -> None:
    found = watch(decay(1400))
    assert found is not None
    assert found.half_period_s == pytest.approx(np.pi / OMEGA, rel=0.03)  # two half periods of 32 samples


@pytest.mark.parametrize(("row", "late"), [(0, 2.0), (1, 1.0)])
def test_one_channel_is_enough(row: int, late: float) -> None:
    """Displacement leaves its noise only with the square of time: at 20 mm in 1.3 samples."""
    found = watch(decay(1400, 400.5)[row : row + 1], BOTH[row : row + 1])
    assert found is not None
    assert 0 <= found.sample - 400.5 <= late


def test_an_impulse_is_found_where_it_struck() -> None:
    t = np.maximum(np.arange(1400) - 400.2, 0) / RATE
    path = 0.4 / OMEGA * np.exp(-DECAY * t) * np.sin(OMEGA * t)
    found = watch(moved(path))
    assert found is not None
    assert abs(found.sample - 400.2) <= 2.0  # the differentiated path smears the blow over two samples


@pytest.mark.parametrize("hand_ms", [5, 12, 20])
def test_a_slow_release_is_found_inside_its_ramp(hand_ms: int) -> None:
    """The hand's force falls as half a cosine: the mass follows by the closed form of a forced spring."""
    steps = 64
    n, release, hand = 1400, 400, hand_ms / 1000
    t = np.arange(n * steps) / (RATE * steps) - release / RATE
    ramp = np.clip(t / hand, 0, 1)
    force = OMEGA**2 * AMPLITUDE * 0.5 * (1 + np.cos(np.pi * ramp))
    x, v, path, acc = AMPLITUDE, 0.0, np.empty(n), np.empty(n)
    for i, f in enumerate(force.tolist()):
        a = f - OMEGA**2 * x - 2 * DECAY * v
        if i % steps == 0:
            path[i // steps], acc[i // steps] = x, a
        v += a / (RATE * steps)
        x += v / (RATE * steps)
    found = watch(np.array([path, acc]) + noise(n))
    assert found is not None
    assert 0 <= found.sample - release <= hand * RATE + 1


def test_noise_alone_never_triggers() -> None:
    assert watch(noise(60_000)) is None


def test_a_pull_does_not_trigger_and_the_release_after_it_does() -> None:
    n, release = 2600, 1500
    path = pull(n, 300, 1.0)
    held = moved(path)
    assert watch(held) is None
    free = decay(n, release)
    held[:, release + 1 :] = free[:, release + 1 :]
    found = watch(held)
    assert found is not None
    assert 0 <= found.sample - release <= 1.0


def test_a_pull_back_and_forth_by_hand_does_not_trigger() -> None:
    n = 4000
    path = pull(n, 300, 0.6) - pull(n, 900, 1.4, 0.03) + pull(n, 1600, 0.5, 0.02) - pull(n, 2300, 1.1, 0.01)
    assert watch(moved(path)) is None


def test_an_unsteady_grip_does_not_trigger() -> None:
    n = 4000
    tremor = 1e-4 * np.sin(2 * np.pi * 9 * np.arange(n) / RATE) * (np.arange(n) > 900)
    assert watch(moved(pull(n, 300, 1.0) + tremor)) is None


@pytest.mark.parametrize("frequency", [12.0, 20.0, 35.0])
def test_a_bump_of_the_table_does_not_trigger(frequency: float) -> None:
    """A table that rings with 0.1 mm, up to 4.8 m/s^2, for a quarter of a second."""
    t = np.maximum(np.arange(3000) - 900, 0) / RATE
    w = 2 * np.pi * frequency
    path = 1e-4 * np.exp(-t / 0.25) * np.sin(w * t)
    a = 1e-4 * w**2 * np.exp(-t / 0.25) * np.sin(w * t)
    assert watch(np.array([path, -a]) + noise(3000)) is None


def test_a_dead_displacement_does_not_keep_the_trigger_from_coming() -> None:
    samples = decay(1400, 400)
    samples[0] = 0.0
    found = watch(samples)
    assert found is not None
    assert found.channel == "a"


def test_lost_samples_do_not_keep_the_trigger_from_coming() -> None:
    samples = decay(1400, 400)
    trigger_at = watch(samples)
    rest = RestPeriod(BOTH, RATE, 0.5)
    rest.feed(samples[:, :200])
    assert rest.noise is not None
    came = np.full_like(samples, np.nan)
    trigger = Trigger(BOTH, RATE, rest.noise, again(came))
    found = None
    for first in range(0, 1400, 16):
        if first % 160 != 80 and found is None:
            came[:, first : first + 16] = samples[:, first : first + 16]
            found = trigger.feed(first, samples[:, first : first + 16])
    assert found is not None
    assert trigger_at is not None
    assert abs(found.sample - trigger_at.sample) <= 16


@pytest.mark.parametrize("block", [1, 7, 64, 1400])
def test_the_cut_into_blocks_does_not_matter(block: int) -> None:
    samples = decay(1400, 400)
    whole, cut = watch(samples, block=16), watch(samples, block=block)
    if block == 1400:
        assert cut is None  # all in one block leaves no rest before it
        return
    assert whole is not None
    assert cut == whole


def scaled(change: Callable[[np.ndarray], np.ndarray]) -> Triggered | None:
    return watch(change(decay(1400, 400)))


def test_a_motion_of_less_than_one_per_cent_of_the_range_is_no_release() -> None:
    assert scaled(lambda s: s * 0.02) is None


def test_a_level_given_by_the_operator_makes_small_releases_count() -> None:
    samples = decay(1400, 400) * 0.02 + 0.98 * noise(1400, 3)
    period = RestPeriod(BOTH, RATE, 0.5, level=1e-4)
    period.feed(samples[:, :300])
    assert period.noise is not None
    found = Trigger(BOTH, RATE, period.noise, again(samples), 1e-4).feed(300, samples[:, 300:])
    assert found is not None


def test_rest_gives_the_noise_of_each_channel() -> None:
    period = RestPeriod(BOTH, RATE, 8.0)
    period.feed(noise(2048))
    assert period.complete
    assert period.noise is not None
    # the standard error of a standard deviation from 2048 samples is 1.6 %; four of them
    assert period.noise == pytest.approx([NOISE_X, NOISE_A], rel=0.064)


def test_a_moving_mass_is_not_at_rest() -> None:
    period = RestPeriod(BOTH, RATE, 0.5)
    period.feed(moved(pull(600, 0, 2.5)))
    assert not period.complete
