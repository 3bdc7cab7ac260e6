"""Columns whose numbers begin again: angles after a turn, counters and converters whose word is full."""

from pathlib import Path

import numpy as np
import pytest
from import_files import load, said, table, write

from daq.importing.reading import look_at
from daq.importing.recipe import Recipe

T = np.arange(1200) / 100.0
SWING = 35.0 * np.exp(-0.12 * T) * np.cos(6.9 * T) + 1.7  # deg, about 1.7 deg


@pytest.mark.parametrize(
    ("header", "scale", "turn", "low"),
    [
        ("angle_deg", 1.0, 360.0, 0.0),
        ("theta (rad)", np.pi / 180.0, 2.0 * np.pi, 0.0),
        ("yaw [deg]", 1.0, 360.0, -180.0),
    ],
)
def test_an_angle_goes_on_where_a_turn_is_full(
    tmp_path: Path, header: str, scale: float, turn: float, low: float
) -> None:
    angle = scale * (SWING + (180.0 if low else 0.0))
    recording = load(tmp_path, table(f"time_s,{header}", T, (angle - low) % turn + low))
    truth = np.radians(SWING)
    assert np.ptp(recording.samples[0] - truth) < 1e-4  # six digits of numbers up to 360 deg
    assert "a turn" in said(recording)


@pytest.mark.parametrize("bits", [12, 16])
def test_a_counter_whose_word_is_full_goes_on_by_a_recipe(tmp_path: Path, bits: int) -> None:
    counts = np.round(SWING / 360.0 * 2.0**bits)
    recipe = Recipe.model_validate(
        {"fields": [{"name": "t_s", "role": "time"},
                    {"name": "raw", "role": "displacement", "unit": "counts", "wraps": 2.0**bits}]}
    )  # fmt: skip
    file = write(tmp_path, table("t_s,raw", T, counts % 2**bits))
    (recording,) = look_at(file, recipe=recipe).read().recordings
    np.testing.assert_array_equal(recording.samples[0], counts)


def test_drop_outs_and_clipped_readings_are_left_as_they_are(tmp_path: Path) -> None:
    """A sonar that loses its echo reads 0, a converter stays at its ends: neither begins again."""
    draw = np.random.default_rng(2)
    lost = np.round(40_000.0 + 9000.0 * np.cos(6.0 * T))
    lost[draw.random(len(T)) < 0.02] = 0.0
    clipped = np.clip(np.round(512.0 + 900.0 * np.cos(6.0 * T)), 0, 1023)
    for numbers in (lost, clipped):
        recording = load(
            tmp_path,
            table("t_s,x", T, numbers),
            columns={"displacement": "x"},
            units={"displacement": "counts"},
        )
        np.testing.assert_array_equal(recording.samples[0], numbers)


def test_a_counter_goes_on_where_its_word_of_two_bytes_is_full(tmp_path: Path) -> None:
    rate = np.round(
        900.0 * np.exp(-0.2 * T) * np.cos(6.0 * T) + 30.0 * np.random.default_rng(4).standard_normal(len(T))
    )
    recording = load(
        tmp_path, table("t_s,gz", T, rate % 65536), columns={"velocity": "gz"}, units={"velocity": "counts"}
    )
    np.testing.assert_array_equal(recording.samples[0], rate)
    assert "jumps by 65536" in said(recording)


def test_lost_readings_near_the_end_of_a_word_are_no_jump(tmp_path: Path) -> None:
    """Two bytes near full scale, and 0 where the converter did not answer: counted on, 0 would read as 65536."""
    counts = np.rint(64000.0 + 20.0 * SWING)
    counts[[300, 301, 700, 1100]] = 0.0
    assert "jumps" not in said(load(tmp_path, table("time_s,accel_g", T, counts)))
