import numpy as np
import pytest
from decays_in_closed_form import coulomb, exponential

from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.aligned_decay import locate_and_align
from identify.preprocessing.motion import Motion, reconstruct
from identify.restoring_force.restoring_force import identify_restoring_force
from identify.wavelet.wavelet import identify_wavelet
from mocks.generate import draw

RATE = 256.0
TIME = np.arange(1200) / RATE + 0.03
NOISE_U, NOISE_V, NOISE_A = 5e-6, 2e-4, 0.01


def inside(motion: Motion) -> slice:
    """All but the first and last period, where a single channel knows less."""
    return slice(65, len(motion.valid) - 65)


def error(motion: Motion, truth: tuple[np.ndarray, np.ndarray, np.ndarray]) -> tuple[float, float, float]:
    made = (motion.displacement, motion.velocity, motion.acceleration)
    window = inside(motion)
    return tuple(float(np.sqrt(np.mean((m - t)[window] ** 2))) for m, t in zip(made, truth, strict=True))  # type: ignore[return-value]


def test_both_channels_give_a_velocity_of_the_stated_noise() -> None:
    truth = exponential(TIME, 3.944)
    rng = np.random.default_rng(1)
    motion = reconstruct(
        FreeDecay(
            RATE,
            displacement=truth[0] + NOISE_U * rng.standard_normal(1200),
            acceleration=truth[2] + 0.3 + NOISE_A * rng.standard_normal(1200),
        )
    )
    u, v, a = error(motion, truth)
    assert motion.source == "displacement and acceleration"
    assert u < 0.4 * NOISE_U  # the accelerometer smooths it: seven samples share the noise
    assert motion.noise_velocity is not None
    assert v == pytest.approx(motion.noise_velocity, rel=0.25)  # some 150 independent values: 6 %
    assert motion.noise_acceleration is not None
    assert a == pytest.approx(motion.noise_acceleration, rel=0.1)  # and the offset is gone


def test_the_three_agree_with_each_other() -> None:
    truth = coulomb(TIME, 3.944)
    rng = np.random.default_rng(2)
    motion = reconstruct(
        FreeDecay(
            RATE,
            displacement=truth[0] + NOISE_U * rng.standard_normal(1200),
            acceleration=truth[2] + NOISE_A * rng.standard_normal(1200),
        )
    )
    gained = np.diff(motion.velocity)[10:-10]
    summed = (0.5 * (motion.acceleration[1:] + motion.acceleration[:-1]) / RATE)[10:-10]
    # The trapezoid errs by the cube of the step, and at a reversal by where the jump fell.
    assert np.median(np.abs(gained - summed)) < 1e-5
    went = np.diff(motion.displacement)[10:-10]
    assert (
        np.median(np.abs(went - (0.5 * (motion.velocity[1:] + motion.velocity[:-1]) / RATE)[10:-10])) < 5e-7
    )


@pytest.mark.parametrize("motion_of", [exponential, coulomb])
def test_an_accelerometer_alone_gives_velocity_and_displacement(motion_of) -> None:
    truth = motion_of(TIME, 3.944)
    noisy = truth[2] + 0.05 + NOISE_A * np.random.default_rng(3).standard_normal(1200)
    motion = reconstruct(FreeDecay(RATE, acceleration=noisy))
    u, v, _ = error(motion, truth)
    assert motion.source == "acceleration"
    assert v < 2.5e-4  # twice the noise integrated over a period of the drift that is taken away
    assert u < 3e-5
    start = np.abs(motion.velocity - truth[1])[:65]
    assert (
        np.sqrt(np.mean(start**2)) < 6e-4
    )  # the first period, where the amplitude is: 0.1 % of the velocity


def test_a_displacement_alone_gives_velocity_and_acceleration() -> None:
    truth = exponential(TIME, 3.944)
    noisy = truth[0] + NOISE_U * np.random.default_rng(4).standard_normal(1200)
    motion = reconstruct(FreeDecay(RATE, displacement=noisy))
    u, v, a = error(motion, truth)
    assert u < 0.6 * NOISE_U
    assert v == pytest.approx(motion.noise_velocity, rel=0.4)
    assert a == pytest.approx(motion.noise_acceleration, rel=0.4)
    assert not motion.valid[0]
    assert motion.valid[100:-100].all()


def test_a_velocity_alone_gives_displacement_and_acceleration() -> None:
    truth = exponential(TIME, 3.944)
    noisy = truth[1] + NOISE_V * np.random.default_rng(5).standard_normal(1200)
    motion = reconstruct(FreeDecay(RATE, velocity=noisy))
    u, v, a = error(motion, truth)
    assert motion.source == "velocity"
    assert u < 3e-5
    assert v < NOISE_V
    assert a < 0.05


def test_a_velocity_and_an_acceleration_agree_too() -> None:
    truth = exponential(TIME, 3.944)
    rng = np.random.default_rng(6)
    motion = reconstruct(
        FreeDecay(
            RATE,
            velocity=truth[1] + NOISE_V * rng.standard_normal(1200),
            acceleration=truth[2] + NOISE_A * rng.standard_normal(1200),
        )
    )
    assert motion.source == "velocity and acceleration"
    u, v, _ = error(motion, truth)
    assert v < 0.5 * NOISE_V
    assert u < 3e-5


def test_lost_samples_are_not_valid_and_do_not_spoil_the_others() -> None:
    truth = exponential(TIME, 3.944)
    valid = np.ones(1200, dtype=bool)
    valid[500:520] = False
    valid[700] = False
    rng = np.random.default_rng(7)
    u = np.where(valid, truth[0] + NOISE_U * rng.standard_normal(1200), 9.0)
    a = np.where(valid, truth[2] + NOISE_A * rng.standard_normal(1200), -90.0)
    motion = reconstruct(FreeDecay(RATE, displacement=u, acceleration=a, valid=valid))
    assert not motion.valid[500:520].any()
    good = motion.valid.copy()
    good[490:530] = good[695:706] = False
    assert np.max(np.abs(motion.velocity - truth[1])[good]) < 5e-4  # eight standard errors


def test_plain_least_squares_on_the_motion_gives_the_parameters() -> None:
    rows = []
    for seed in range(24):
        sample = draw(None, 0.0, seed, noise_displacement=5e-6, noise_acceleration=0.01)
        found = locate_and_align(FreeDecay(RATE, sample.displacement, sample.acceleration))
        motion = reconstruct(found.decay.with_(release=found.release.settle))
        used = motion.valid & (np.abs(motion.velocity) > 0.03)
        u, v = motion.displacement[used], motion.velocity[used]
        columns = np.column_stack([u, v, np.sign(v), np.ones(len(u))])
        k, mu_1, mu_0, _ = np.linalg.lstsq(columns, -motion.acceleration[used], rcond=None)[0]
        truth = sample.truth
        rows.append((k / truth["stiffness_per_mass"] - 1, mu_0 / truth["mu_0"] - 1, mu_1 / truth["mu_1"] - 1))
    k, mu_0, mu_1 = np.sqrt(np.mean(np.array(rows) ** 2, axis=0))
    assert k < 1e-4  # what the station has to reach: 0.01 %, 0.6 %, 1.2 %
    assert mu_0 < 6e-3
    assert mu_1 < 1.2e-2


def test_too_few_samples_are_refused_in_words() -> None:
    with pytest.raises(NotIdentifiable, match="readings follow the release"):
        reconstruct(FreeDecay(RATE, displacement=np.zeros(40), release=30))


def test_a_record_without_a_reading_is_refused_in_words():
    time = np.arange(512) / 256.0
    u = 0.02 * np.cos(25.0 * time)
    lost = FreeDecay(256.0, u, -625.0 * u, release=0, valid=np.zeros(512, dtype=bool))
    for identified in (reconstruct, identify_wavelet, identify_restoring_force):
        with pytest.raises(NotIdentifiable, match="Only 0 readings follow the release"):
            identified(lost)


@pytest.mark.parametrize("gap", [3.0, 12.0])
def test_readings_that_are_lost_for_seconds_leave_a_motion(gap):
    sample = draw(None, 0.0, 911, seconds=30.0, mu_0=0.03, mu_1=0.05)
    valid = np.ones(len(sample.displacement), dtype=bool)
    first = int(2.0 * sample.rate)
    valid[first : first + int(gap * sample.rate)] = False
    motion = reconstruct(FreeDecay(sample.rate, sample.displacement, valid=valid, release=256))
    assert np.isfinite(motion.displacement).all()
