"""A sensor that is asked faster than it answers: each answer is written again until the next."""

import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from import_files import load, said, table

from daq.importing.held_readings import held_readings
from daq.quality import judge
from daq.recording import Array


def asked(answers: float, rate: float, seconds: float, jitter: float = 0.0) -> tuple[Array, Array]:
    """Return the times (s) at which a program asks at a `rate`, Hz, with a jitter, s, and when what it gets was measured."""
    rng = np.random.default_rng(3)
    times = np.arange(int(seconds * rate)) / rate + jitter * rng.random(int(seconds * rate))
    return times, np.floor(times * answers + 0.3) / answers - 0.3 / answers


def motion(times: Array, frequency: float) -> Array:
    """Return a displacement in mm of 40 mm that decays."""
    return 40.0 * np.exp(-0.15 * times) * np.cos(2 * np.pi * frequency * times)


@pytest.mark.parametrize(
    ("answers", "rate", "frequency", "jitter", "step"),
    [
        (397.3, 533.0, 21.0, 8e-6, 0.01),  # an accelerometer read by a microcontroller
        (19.7, 100.0, 0.9, 1e-3, 0.1),  # a sonar
        (30.2, 50.0, 1.1, 2e-3, 1.0),  # a time-of-flight sensor in whole mm
        (100.0, 190.0, 4.0, 0.0, 0.05),
    ],
)
def test_the_sensor_s_own_readings_are_taken(
    tmp_path: Path, answers: float, rate: float, frequency: float, jitter: float, step: float
) -> None:
    times, measured = asked(answers, rate, 30.0 / frequency, jitter)
    u = np.round(motion(measured, frequency) / step) * step
    recording = load(tmp_path, table("t (ms),x (mm)", np.round(1e3 * times, 3), u))
    assert recording.rate == pytest.approx(answers, rel=2e-3)
    assert "% of the rows repeat the one before" in said(recording)
    values = 1e3 * recording.samples[0]
    there = recording.valid & np.isfinite(values)
    assert np.mean(there) > 0.98
    clock = measured[0] + np.arange(len(values)) / recording.rate
    shifts = [measured[0] + k / answers - clock[0] for k in (-1, 0, 1)]
    misfit = min(float(np.std((values - motion(clock + s, frequency))[there])) for s in shifts)
    held = float(np.std(motion(times, frequency) - motion(measured, frequency)))
    assert misfit < max(0.15 * held, 0.5 * step)


def test_rounded_and_slow_readings_are_not_held(tmp_path: Path) -> None:
    times = np.arange(3000) / 200.0
    coarse = np.round(motion(times, 0.4) / 2.0) * 2.0  # 40 levels, a few rows each
    recording = load(tmp_path, table("t (s),x (mm)", times, coarse))
    assert recording.rate == 200.0
    assert "repeat" not in said(recording)


def test_readings_in_pixels_that_repeat_by_rounding_are_not_held(tmp_path: Path) -> None:
    """A pixel of 0.311166 mm is no round step; a fifth of the rows repeats, by rounding alone."""
    times = np.arange(660) / 119.88
    u = np.round(60.0 * np.exp(-0.5 * times) * np.cos(4.8 * times) / 0.311166) * 0.311166
    recording = load(tmp_path, table("Time (s),X (mm)", np.round(times, 3), np.round(u, 4)))
    assert np.mean(np.diff(u) == 0.0) > 0.1
    assert recording.rate == pytest.approx(119.88, rel=1e-4)
    assert "repeat" not in said(recording)


def test_a_few_rows_written_again_are_no_clock() -> None:
    times = np.arange(2000) / 100.0
    values = motion(times, 1.3)
    again = np.flatnonzero(np.random.default_rng(4).random(2000) < 0.2)
    values[again[1:]] = values[again[1:] - 1]  # at random: frames that a program lost
    assert held_readings(times, values[None]) is None


def test_a_pause_in_the_questions_is_lost_and_not_filled() -> None:
    times, measured = asked(40.0, 100.0, 30.0)
    keep = (times < 11.0) | (times > 11.6)
    found = held_readings(times[keep], motion(measured, 1.2)[None, keep])
    assert found is not None
    missing = np.setdiff1d(np.arange(found.index[-1]), found.index)
    assert 20 <= len(missing) <= 26
    assert np.all(np.diff(missing) == 1)


def test_a_long_rest_before_the_release_costs_nothing() -> None:
    """Ten minutes without a new reading, as of a sensor whose noise is less than a step."""
    times, measured = asked(100.0, 190.0, 12.0)
    u = np.round(motion(measured, 4.0) / 0.05) * 0.05
    rest = np.arange(int(600 * 190.0)) / 190.0
    tracemalloc.start()
    found = held_readings(np.concatenate([rest, 600.0 + times]), np.concatenate([0.0 * rest + u[0], u])[None])
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found is not None
    assert 1.0 / found.period == pytest.approx(100.0, rel=2e-3)
    assert most < 5e7  # bytes


def test_readings_that_are_held_by_no_clock_are_told(tmp_path: Path) -> None:
    times = np.arange(600) / 30.0
    new = np.random.default_rng(4).random(600) < 0.4  # a camera's tracker that finds its ball now and then
    new[0] = True
    measured = times[np.maximum.accumulate(np.where(new, np.arange(600), 0))]
    recording = load(tmp_path, table("t (s),x (mm)", times, np.round(motion(measured, 1.1), 3)))
    assert recording.rate == pytest.approx(30.0)
    assert "x (mm) repeats the reading before it" in str(judge(recording))
