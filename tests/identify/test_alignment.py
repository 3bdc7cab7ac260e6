import json
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from decays_in_closed_form import coulomb, exponential

from identify.errors import NotIdentifiable
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import align, correct
from identify.preprocessing.release import release_of
from identify.signal.kinematics import Pair, agree
from mocks.generate import Sample, draw

RATE = 256.0
HIDDEN = Path(__file__).resolve().parents[1] / "data" / "hidden"


def drawn(seed: int, **fixed: float) -> Sample:
    """The working point: 5 um, 0.01 m/s^2, lag +-3 ms, an ideal hand or one of up to 12 ms."""
    amplitude = (-0.025, -0.02, -0.015, 0.02, 0.025)[seed % 5]
    decays = {"noise_displacement": 5e-6, "noise_acceleration": 0.01, "amplitude": amplitude} | fixed
    return draw(None, 0.0, seed, **decays)


def decay_of(sample: Sample, start: int = 0, stop: int | None = None) -> FreeDecay:
    found = release_of(FreeDecay(RATE, displacement=sample.displacement, acceleration=sample.acceleration))
    window = slice(start, stop)
    whole = {"release": found.index, "rest": found.rest} if (start, stop) == (0, None) else {}
    return FreeDecay(
        RATE, displacement=sample.displacement[window], acceleration=sample.acceleration[window], **whole
    )


def errors(samples: list[Sample], start: int = 0, stop: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Errors of lag (s) and gain with their standard errors, shape (samples, 2) each."""
    found = [align(decay_of(sample, start, stop)) for sample in samples]
    truths = [sample.truth for sample in samples]
    lag = [(f.lag.value - t["displacement_late_s"], f.lag.std) for f, t in zip(found, truths, strict=True)]
    gain = [(f.gain.value - t["gain"], f.gain.std) for f, t in zip(found, truths, strict=True)]
    return np.array(lag), np.array(gain)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def test_from_rest_to_rest_the_lag_is_known_within_four_microseconds() -> None:
    rng = np.random.default_rng(0)
    lag, gain = errors([drawn(seed, gain_error=rng.uniform(-0.01, 0.01)) for seed in range(20)])
    assert rms(lag[:, 0]) < 4e-6
    assert (
        abs(lag[:, 0].mean()) < 2e-6
    )  # 1 us is shown on 540 draws in the bench; the mean of 20 is known within 0.7
    assert 0.65 < rms(lag[:, 0] / lag[:, 1]) < 1.4  # twenty draws leave 16 % on it
    assert rms(gain[:, 0]) < 1.2e-4
    assert 0.75 < rms(gain[:, 0] / gain[:, 1]) < 1.3


@pytest.mark.parametrize(("start", "stop"), [(256, None), (256, 384)])
def test_in_mid_decay_the_lag_is_known_within_twenty_microseconds(start: int, stop: int | None) -> None:
    lag, _ = errors([drawn(seed) for seed in range(100, 112)], start, stop)
    assert rms(lag[:, 0]) < 20e-6
    assert abs(lag[:, 0].mean()) < 4 * rms(lag[:, 1]) / 12**0.5  # four standard errors of the mean of 12
    assert 0.45 < rms(lag[:, 0] / lag[:, 1]) < 1.6  # twelve draws


@pytest.mark.parametrize("damping", [0.0, 0.14, 2.0])
@pytest.mark.parametrize("lag", [-11e-3, -1.1e-3, 0.0, 2.93e-3])
def test_damping_does_not_pass_for_a_lag(damping: float, lag: float) -> None:
    time = np.arange(700) / RATE
    u = exponential(time - lag, 3.944, decay=damping)[0]
    a = 1.01 * exponential(time, 3.944, decay=damping)[2] + 0.05
    found = align(
        FreeDecay(RATE, displacement=u, acceleration=a, noise_displacement=5e-6, noise_acceleration=0.01)
    )
    assert found.lag.value == pytest.approx(lag, abs=1e-7)  # no noise: what is left is the interpolation's
    assert found.gain.value == pytest.approx(1.01, rel=1e-6)


def test_dry_friction_s_jumps_do_not_pass_for_a_lag() -> None:
    errors_s = []
    for lag in np.linspace(-3e-3, 3e-3, 13):
        time = np.arange(1400) / RATE + 0.31
        u, a = coulomb(time - lag, 3.944)[0], coulomb(time, 3.944)[2]
        decay = FreeDecay(
            RATE, displacement=u, acceleration=a, noise_displacement=5e-6, noise_acceleration=0.01
        )
        errors_s.append(align(decay).lag.value - lag)
    assert (
        rms(np.array(errors_s)) < 5e-7
    )  # the jumps fall between samples; a fifth of the noise's share is allowed


def test_a_laser_vibrometer_aligns_too() -> None:
    z = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        lag, time = rng.uniform(-3e-3, 3e-3), np.arange(1000) / RATE + 0.1
        v = coulomb(time - lag, 3.944)[1] + 2e-4 * rng.standard_normal(1000)
        a = coulomb(time, 3.944)[2] + 0.01 * rng.standard_normal(1000)
        found = align(FreeDecay(RATE, velocity=v, acceleration=a))
        assert abs(found.lag.value - lag) < 40e-6
        assert "velocity" in found.method
        z.append((found.lag.value - lag) / found.lag.std)
    assert 0.5 < rms(np.array(z)) < 1.6  # twelve draws


@pytest.mark.parametrize("rate", [60.0, 1000.0, 20000.0])
def test_other_rates_align(rate: float) -> None:
    rng = np.random.default_rng(4)
    time = np.arange(int(3 * rate)) / rate + 0.05
    u = exponential(time - 1.7e-3, 3.944)[0] + 5e-6 * rng.standard_normal(len(time))
    a = exponential(time, 3.944)[2] + 0.01 * rng.standard_normal(len(time))
    found = align(FreeDecay(rate, displacement=u, acceleration=a))
    assert abs(found.lag.value - 1.7e-3) < 4 * found.lag.std
    assert found.lag.std < 4e-6 * np.sqrt(256 / rate)  # as the samples become more


def test_dropouts_are_left_out() -> None:
    sample = drawn(7)
    rng = np.random.default_rng(7)
    valid = rng.random(len(sample.displacement)) > 0.03
    valid[900:960] = False
    wrong = np.where(valid, sample.displacement, 0.04)
    decay = FreeDecay(
        RATE,
        displacement=wrong,
        acceleration=np.where(valid, sample.acceleration, -40.0),
        release=193,
        rest=(0, 180),
        valid=valid,
    )
    found = align(decay)
    assert abs(found.lag.value - sample.truth["displacement_late_s"]) < 4 * found.lag.std
    assert found.lag.std < 8e-6  # a few samples less, not another method


def test_a_sensor_mounted_upside_down_is_told() -> None:
    sample = drawn(9)
    found = align(
        FreeDecay(
            RATE,
            displacement=sample.displacement,
            acceleration=-sample.acceleration,
            release=193,
            rest=(0, 180),
        )
    )
    assert found.gain.value == pytest.approx(-1.0, abs=1e-3)
    assert "opposite" in found.caution


def test_one_channel_is_refused_in_words() -> None:
    with pytest.raises(NotIdentifiable, match="without an acceleration"):
        align(FreeDecay(RATE, displacement=np.zeros(500)))


def test_no_motion_is_refused_in_words() -> None:
    rng = np.random.default_rng(2)
    with pytest.raises(NotIdentifiable, match="motion"):
        align(
            FreeDecay(
                RATE,
                displacement=5e-6 * rng.standard_normal(900),
                acceleration=0.01 * rng.standard_normal(900),
            )
        )


def test_correcting_moves_the_displacement_and_scales_the_acceleration() -> None:
    time = np.arange(800) / RATE
    u, a = exponential(time - 2.2e-3, 3.944)[0], 0.99 * exponential(time, 3.944)[2]
    decay = FreeDecay(RATE, displacement=u, acceleration=a, noise_displacement=5e-6, noise_acceleration=0.01)
    moved = correct(decay, align(decay))
    assert moved.displacement is not None
    assert moved.acceleration is not None
    inside = slice(8, -8)
    assert np.max(np.abs(moved.displacement - exponential(time, 3.944)[0])[inside]) < 1e-7  # v times 1e-7 s
    assert np.max(np.abs(moved.acceleration - exponential(time, 3.944)[2])[inside]) < 1e-4


def lag_score(displacement: np.ndarray, acceleration: np.ndarray, late: float) -> float:
    """The error of the lag in its standard errors."""
    release = release_of(FreeDecay(RATE, displacement=displacement, acceleration=acceleration))
    decay = FreeDecay(
        RATE,
        displacement=displacement,
        acceleration=acceleration,
        release=release.index,
        rest=release.rest,
    )
    found = align(decay)
    return (found.lag.value - late) / found.lag.std


@pytest.mark.parametrize(
    "truth", json.loads((HIDDEN / "truth.json").read_text()), ids=lambda truth: truth["hidden"]
)
def test_hidden_physics_does_not_pass_for_a_lag(truth: dict) -> None:
    _, u, a = np.loadtxt(HIDDEN / truth["file"], delimiter=",", skiprows=1).T
    assert abs(lag_score(u, a, truth["displacement_late_s"])) < 3.5


def test_a_coupling_capacitor_passes_for_a_lag() -> None:
    """An AC-coupled accelerometer leads by its corner over the frequency: at one frequency that is a lag."""
    sample = draw("ac_coupling", 0.01, 3)
    score = lag_score(sample.displacement, sample.acceleration, sample.truth["displacement_late_s"])
    assert abs(score) > 50


def test_a_stated_lag_that_contradicts_the_motion_is_said() -> None:
    decay = decay_of(drawn(3))
    found = align(decay.with_(stated_lag=Estimate(0.02, 1e-3, "s")))
    assert found.lag == align(decay).lag
    assert "suspect the delays that the board states" in found.caution
    near = Estimate(found.lag.value + 1e-3, 1e-3, "s")
    assert align(decay.with_(stated_lag=near)).caution == align(decay).caution


def test_channels_without_any_noise_are_refused_or_aligned_and_do_not_fail():
    """A simulation of somebody else may have none: what cannot be solved is refused in words."""
    for count in (40, 64, 100, 400):
        time = np.arange(count) / 50.0
        u, _, a = exponential(time, 2.0)
        with suppress(NotIdentifiable):
            assert abs(align(FreeDecay(50.0, displacement=u, acceleration=a)).lag.value) < 0.05


def test_a_lag_of_exactly_none_is_refined_as_one_beside_it():
    time = np.arange(400) / 100.0
    u, _, a = exponential(time, 2.0)
    noise = np.random.default_rng(4).standard_normal((2, len(time)))
    sizes = 1e-3 * np.array([np.std(u), np.std(a)])
    u, a = u + sizes[0] * noise[0], a + sizes[1] * noise[1]
    spread = (np.full(len(time), size**2) for size in sizes)
    pair = Pair(u, a, 2, 100.0, *spread, excess=np.zeros(len(time)))
    none, beside = (agree(pair, lag, 1.0, 0.04) for lag in (0.0, 1e-5))
    assert none.lag == pytest.approx(beside.lag, abs=1e-6)
    assert abs(none.lag) < 1e-3
