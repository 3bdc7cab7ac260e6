from dataclasses import replace

import numpy as np
import pytest
from scripted_board import RATE, decay

from daq.quality import Grade, judge
from daq.recording import Channel, Gap, Recording

X = Channel("x", "displacement", "m", 1e-6, -0.05, 0.05)
A = Channel("a", "acceleration", "m/s^2", 1e-3, -50.0, 50.0)
N = 2304


def good() -> Recording:
    return Recording(RATE, (X, A), decay(N, 256), np.ones(N, dtype=bool), trigger=256)


def with_samples(change: np.ndarray) -> Recording:
    return replace(good(), samples=change)


def lost(first: int, count: int) -> Recording:
    valid = np.ones(N, dtype=bool)
    valid[first : first + count] = False
    return replace(good(), valid=valid, gaps=(Gap(first, count, "wire"),))


def test_a_good_recording_is_ok() -> None:
    assert judge(good(), planned=N, noise={"x": 5e-6, "a": 0.01}).grade is Grade.OK


def test_a_short_gap_leaves_it_usable_and_says_how_many() -> None:
    verdict = judge(lost(800, 16))
    assert verdict.grade is Grade.USABLE
    assert "16 of 2304 samples lost: 16 on the wire; the longest gap 62 ms" in verdict.reasons[0]


def test_a_gap_before_the_release_is_said_to_be_there() -> None:
    assert "all before the release" in judge(lost(50, 16)).reasons[0]


@pytest.mark.parametrize("count", [47, 65])  # 2 % of 2304 are 46; 0.25 s are 64
def test_too_many_gaps_are_a_reject(count: int) -> None:
    assert judge(lost(800, count)).grade is Grade.REJECT


def test_a_dead_channel_is_a_reject() -> None:
    samples = decay(N, 256)
    samples[1] = 0.0
    verdict = judge(with_samples(samples))
    assert verdict.grade is Grade.REJECT
    assert any("a does not move" in reason for reason in verdict.reasons)


def test_saturation_is_a_reject() -> None:
    samples = np.clip(decay(N, 256), [[-0.05], [-8.0]], [[0.05], [8.0]])
    narrow = replace(A, low=-8.0, high=8.0)
    verdict = judge(replace(good(), channels=(X, narrow), samples=samples))
    assert verdict.grade is Grade.REJECT
    assert any("end of its range" in reason for reason in verdict.reasons)


def test_too_little_motion_is_a_reject() -> None:
    noise = np.random.default_rng(0).normal(size=(2, N)) * [[5e-6], [0.01]]
    verdict = judge(with_samples(noise), noise={"x": 5e-6, "a": 0.01})
    assert verdict.grade is Grade.REJECT
    assert any("times its noise" in reason for reason in verdict.reasons)


def test_a_reversed_sensor_is_a_reject() -> None:
    verdict = judge(with_samples(decay(N, 256) * [[1.0], [-1.0]]))
    assert any("reversed" in reason for reason in verdict.reasons)


def test_swapped_channels_are_a_reject() -> None:
    verdict = judge(with_samples(decay(N, 256)[::-1] * [[1e-3], [1e3]]))
    assert any("swapped" in reason for reason in verdict.reasons)


def test_a_recording_that_ends_early_says_by_how_much() -> None:
    short = replace(good(), samples=decay(N, 256)[:, :1600], valid=np.ones(1600, dtype=bool))
    verdict = judge(short, planned=N)
    assert verdict.grade is Grade.USABLE
    assert "ends 2.75 s early, after 1600 of 2304 samples" in verdict.reasons[0]


def test_a_trigger_that_came_early_is_said() -> None:
    assert any("before the release" in r for r in judge(replace(good(), trigger=20)).reasons)


def test_a_verdict_says_what_to_do() -> None:
    assert judge(lost(800, 16)).advice


def test_one_channel_is_judged_without_kinematics() -> None:
    one = Recording(RATE, (X,), decay(N, 256)[:1], np.ones(N, dtype=bool), trigger=256)
    assert judge(one).grade is Grade.OK


def test_a_blow_that_saturates_leaves_it_usable() -> None:
    samples = decay(N, 256)
    samples[1, 256:259] = 50.0
    verdict = judge(with_samples(samples))
    assert verdict.grade is Grade.USABLE
    assert "a is at the end of its range in 3 samples at the release" in verdict.reasons[0]
