"""Recordings of real boards that come with the repository import, and mean what their owners say."""

from pathlib import Path

import numpy as np
import pytest
from import_files import said

from daq.importing import ImportOptions, ImportProblem, read_file

ROOT = Path(__file__).parents[3]
EXAMPLES = ROOT / "examples"


@pytest.mark.parametrize("path", sorted((ROOT / "tests" / "data").rglob("*.csv")), ids=lambda path: path.stem)
def test_releases_of_another_program_need_no_options(path: Path) -> None:
    recording = read_file(path)
    np.testing.assert_array_equal(recording.samples, np.loadtxt(path, delimiter=",", skiprows=1)[:, 1:].T)
    assert (recording.rate, recording.valid.all(), recording.gaps) == (256.0, True, ())
    assert [(c.quantity, c.unit) for c in recording.channels] == [
        ("displacement", "m"),
        ("acceleration", "m/s^2"),
    ]


def test_the_spring_discs_computed_channels_are_left_out() -> None:
    path = EXAMPLES / "spring_disc.csv"
    recording = read_file(path)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m")]
    np.testing.assert_array_equal(recording.samples[0], np.loadtxt(path, delimiter=";", skiprows=1)[:, 1])
    assert recording.rate == pytest.approx(100.0, rel=1e-9)
    assert "'velocity' was left out" in said(recording)
    assert "'acceleration' was left out" in said(recording)


def test_the_ships_roll_is_an_angle_on_the_clock_of_its_file() -> None:
    path = EXAMPLES / "ship_roll.csv"
    recording = read_file(path)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    np.testing.assert_allclose(recording.samples[0], np.loadtxt(path, delimiter=",", skiprows=1)[:, 1])
    assert recording.rate == pytest.approx(100.0, rel=1e-6)


def test_the_silverbox_takes_names_units_and_a_rate() -> None:
    path = EXAMPLES / "silverbox.mat"
    with pytest.raises(ImportProblem, match="'V2'"):
        read_file(path)
    options = ImportOptions(
        columns={"force": "V1", "displacement": "V2"}, units={"force": "V", "displacement": "V"}, rate=610.35
    )
    recording = read_file(path, options)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "V"), ("force", "V")]
    assert recording.rate == 610.35
    assert recording.valid.all()
