"""Columns whose numbers begin again: angles after a turn, counters and converters whose word is full."""

from pathlib import Path

import numpy as np
import pytest
from import_files import load, table, write

from daq.importing.reading import look_at
from daq.importing.recipe import Recipe
from daq.quality import judge

T = np.arange(1200) / 100.0
SWING = 35.0 * np.exp(-0.12 * T) * np.cos(6.9 * T) + 1.7  # deg, about 1.7 deg


@pytest.mark.parametrize("header", ["angle_deg", "yaw [deg]"])
@pytest.mark.parametrize(("scale", "middle"), [(1.0, 0.0), (1.0, 180.0), (20.0, 0.0)])
def test_the_verdict_says_that_an_angle_begins_again_and_a_recipe_counts_it_on(
    tmp_path: Path, header: str, scale: float, middle: float
) -> None:
    angle = scale * SWING + middle
    low = -180.0 if middle else 0.0
    text = table(f"time_s,{header}", T, (angle - low) % 360.0 + low)
    verdict = judge(load(tmp_path, text))
    assert "wraps round from one end of its range to the other" in verdict.words
    assert any("wraps = 360" in advice for advice in verdict.advice)
    recipe = Recipe.model_validate(
        {"fields": [{"column": 1, "role": "time"}, {"column": 2, "role": "displacement", "unit": "deg", "wraps": 360}]}
    )  # fmt: skip
    (recording,) = look_at(tmp_path / "a.csv", recipe=recipe).read().recordings
    assert (
        np.ptp(recording.samples[0] - np.radians(scale * SWING)) < 1e-4
    )  # six digits of numbers up to 360 deg


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
