"""Channels that the logger computed are found; sensors of their own never are."""

from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, load, said

from daq.importing import ImportOptions, read_file
from daq.importing.column_numbers import quantum
from daq.importing.derived import find_derivation
from mocks import generate

RATE = 200.0
HIDDEN = Path(__file__).parents[2] / "data" / "hidden"


def motion(n: int, noise: float, seed: int, step: float = 1e-5) -> np.ndarray:
    t = np.arange(n) / RATE
    u = 0.02 * np.exp(-0.1 * t) * np.cos(OMEGA * t) + np.random.default_rng(seed).normal(0.0, noise, n)
    return np.round(u / step) * step


KERNELS = {
    "backward": [-1.0, 1.0, 0.0],
    "central": [-0.5, 0.0, 0.5],
    "smoothed": [-1 / 6, -1 / 6, 0.0, 1 / 6, 1 / 6],
    "slope of a line through seven": list(np.arange(-3, 4) / 28.0),
}


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("decimals", [4, 6])
@pytest.mark.parametrize("noise", [0.0, 2e-5])
def test_a_logged_difference_is_found(kernel: str, decimals: int, noise: float) -> None:
    u = motion(1500, noise, 1)
    weights = np.array(KERNELS[kernel]) * RATE
    v = np.round(np.convolve(u, weights[::-1], "same"), decimals)[10:-10]
    assert find_derivation(u[10:-10], v, RATE, 1) is not None


def test_a_second_difference_is_found() -> None:
    u = motion(1500, 2e-5, 2)
    a = np.convolve(u, np.array([1.0, -2.0, 1.0]) * RATE**2, "same")[10:-10]
    assert find_derivation(u[10:-10], a, RATE, 2) is not None


def test_a_difference_over_the_loggers_own_uneven_steps_is_found() -> None:
    random = np.random.default_rng(3)
    stamps = np.arange(800) / 10.0 + random.normal(0.0, 5e-4, 800)
    u = np.round(2.0 * np.exp(-0.01 * stamps) * np.cos(3.27 * stamps), 2)
    v = np.full(800, np.nan)
    v[1:-1] = (u[2:] - u[:-2]) / (stamps[2:] - stamps[:-2])
    assert find_derivation(u, v, 10.0, 1, stamps) is not None


@pytest.mark.parametrize("seed", range(12))
def test_a_simulated_accelerometer_is_a_sensor_of_its_own(seed: int) -> None:
    sample = generate.draw(None, 0.0, seed)
    assert find_derivation(sample.displacement, sample.acceleration, sample.rate, 2) is None


def test_the_accelerometers_of_the_hidden_releases_are_sensors_of_their_own() -> None:
    for path in sorted(HIDDEN.glob("*.csv")):
        recording = read_file(path, ImportOptions())
        assert [c.quantity for c in recording.channels] == ["displacement", "acceleration"], path.name


@pytest.mark.parametrize("rate", [10.0, 50.0, 256.0, 5000.0])
@pytest.mark.parametrize("decimals", [5, 8, 15])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("friction", [False, True])
def test_a_clean_simulation_is_no_derivation_at_any_rate_or_rounding(
    rate: float, decimals: int, order: int, friction: bool
) -> None:
    """Without noise, the closed form of the velocity is close to a difference of the displacement, yet is none."""
    t = np.arange(2000) / rate
    pole = complex(-0.1, OMEGA)
    u = 0.02 * np.exp(pole * t)
    exact = (pole**order * u).real
    if friction and order == 2:
        exact = exact - 0.13 * np.sign((pole * u).real)
    channel = np.round(exact, decimals)
    assert find_derivation(np.round(u.real, decimals), channel, rate, order) is None


@pytest.mark.parametrize("noise", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("step", [1e-4, 1e-6])
@pytest.mark.parametrize("seed", range(4))
def test_a_vibrometer_beside_a_displacement_sensor_is_a_sensor_of_its_own(
    noise: float, step: float, seed: int
) -> None:
    t = np.arange(2048) / 256.0
    pole = complex(-0.1, OMEGA)
    random = np.random.default_rng(seed)
    v = np.round((pole * 0.02 * np.exp(pole * t)).real + random.normal(0.0, noise, t.size), 6)
    u = np.round((0.02 * np.exp(pole * t)).real / step + random.normal(0.0, 0.5, t.size)) * step
    assert find_derivation(u, v, 256.0, 1) is None


def test_a_derived_channel_is_left_out_with_a_note_and_kept_when_asked(tmp_path: Path) -> None:
    u = motion(1500, 2e-5, 5)
    v = np.convolve(u, np.array(KERNELS["central"])[::-1] * RATE, "same")
    rows = [f"{i / RATE:.4f};{u[i]:.5f};{v[i]:.4f}" for i in range(1, 1499)]
    text = "time;position;velocity\n0.0000;0.02000;\n" + "\n".join(rows)
    recording = load(tmp_path, text)
    assert [c.quantity for c in recording.channels] == ["displacement"]
    assert recording.valid.all()  # the empty velocity of the first row went with its column
    assert "'velocity' was left out" in said(recording)
    kept = load(tmp_path, text, keep_derived=True)
    assert [c.quantity for c in kept.channels] == ["displacement", "velocity"]


def test_too_short_a_record_is_not_judged() -> None:
    u = motion(30, 2e-5, 6)
    assert find_derivation(u, np.gradient(u), RATE, 1) is None


@pytest.mark.parametrize("step", [1.0, 0.5, 0.025, 1e-4, 2e-6])
def test_the_rounding_of_a_column_is_seen(step: float) -> None:
    values = np.round(np.random.default_rng(7).normal(0.0, 300, 500)) * step
    assert quantum(values) == pytest.approx(step)
