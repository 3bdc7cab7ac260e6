"""Channels that the logger computed are found; sensors of their own never are."""

from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, load, said, write

from daq.importing import ImportOptions, read_file, read_runs
from daq.importing.column_numbers import is_difference, quantum
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
    "weighted over seven": [-1 / 36, -1 / 12, -1 / 4, 0.0, 1 / 4, 1 / 12, 1 / 36],
    "slope of a line through seven": list(np.arange(-3, 4) / 28.0),
}


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize("decimals", [4, 6])
@pytest.mark.parametrize("noise", [0.0, 2e-5])
def test_a_logged_difference_is_found(kernel: str, decimals: int, noise: float) -> None:
    u = motion(1500, noise, 1)
    weights = np.array(KERNELS[kernel]) * RATE
    v = np.round(np.convolve(u, weights[::-1], "same"), decimals)[10:-10]
    hidden = kernel.startswith("slope") and noise == 0.0 and decimals == 4  # by the rounding of the velocity
    assert is_difference(u[10:-10], v, 1) != hidden


def test_a_second_difference_is_found() -> None:
    u = motion(1500, 2e-5, 2)
    a = np.convolve(u, np.array([1.0, -2.0, 1.0]) * RATE**2, "same")[10:-10]
    assert is_difference(u[10:-10], a, 2)


def test_a_difference_over_the_loggers_own_uneven_steps_is_found() -> None:
    random = np.random.default_rng(3)
    stamps = np.arange(800) / 10.0 + random.normal(0.0, 5e-4, 800)
    u = np.round(2.0 * np.exp(-0.01 * stamps) * np.cos(3.27 * stamps), 2)
    v = np.full(800, np.nan)
    v[1:-1] = (u[2:] - u[:-2]) / (stamps[2:] - stamps[:-2])
    assert is_difference(u, v, 1)


@pytest.mark.parametrize("seed", range(12))
def test_a_simulated_accelerometer_is_a_sensor_of_its_own(seed: int) -> None:
    sample = generate.draw(None, 0.0, seed)
    assert not is_difference(sample.displacement, sample.acceleration, 2)


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
    assert not is_difference(np.round(u.real, decimals), channel, order)


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
    assert not is_difference(u, v, 1)


@pytest.mark.parametrize("every", [1, 5, 10])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("seed", [11, 21, 22])
def test_modes_that_two_sensors_share_are_no_derivation(every: int, order: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    t = np.arange(3000) / RATE
    frequencies = 3.9, random.uniform(8, 40), random.uniform(20, 90)
    poles = [complex(-0.1 - f / 80, 2 * np.pi * f) for f in frequencies]
    sizes = 0.02, 0.02 * 10 ** random.uniform(-4, -1), 0.02 * 10 ** random.uniform(-5, -1)
    modes = [size * np.exp(pole * t) for size, pole in zip(sizes, poles, strict=True)]
    u = sum(mode.real for mode in modes) + random.normal(0.0, 1e-6, t.size)
    v = sum((pole**order * mode).real for pole, mode in zip(poles, modes, strict=True))
    v = v + random.normal(0.0, 1e-3 if order == 2 else 5e-5, t.size)
    for decimals in (5, 15):
        seen = np.round(u, decimals)[::every], np.round(v, decimals - 4 + order)[::every]
        assert not is_difference(*seen, order)


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


def test_what_one_run_shows_of_a_derived_channel_is_true_of_all(tmp_path: Path) -> None:
    rows = []
    for i in range(400):
        u = motion(402, 2e-5, 7)
        w = np.round(u, 3)  # too coarse for a difference of it to show anything
        v = (u[i + 2] - u[i]) * RATE / 2.0
        rows.append(f"{i / RATE:.3f};{u[i + 1]:.5f};{v:.4f};{i / RATE:.3f};{w[i + 1]:.3f};{v:.4f}")
    recordings = read_runs(write(tmp_path, "t1;x1;v1;t2;x2;v2\n" + "\n".join(rows)))
    assert [[c.quantity for c in one.channels] for one in recordings] == [["displacement"]] * 2
    assert "column 6 'v' was left out" in said(recordings[1])


def test_too_short_a_record_is_not_judged() -> None:
    u = motion(30, 2e-5, 6)
    assert not is_difference(u, np.gradient(u), 1)


@pytest.mark.parametrize("step", [1.0, 0.5, 0.025, 1e-4, 2e-6])
def test_the_rounding_of_a_column_is_seen(step: float) -> None:
    values = np.round(np.random.default_rng(7).normal(0.0, 300, 500)) * step
    assert quantum(values) == pytest.approx(step)
