"""Every real recording beside the repository imports, and means what its owner says."""

import numpy as np
import pytest
from import_files import data_folder, said

from daq.importing import ImportOptions, ImportProblem, read_file


@pytest.mark.parametrize("number", range(27))
def test_the_testbeds_releases_need_no_options(number: int) -> None:
    path = data_folder() / "hidden" / f"release_{number:02d}.csv"
    recording = read_file(path)
    truth = np.loadtxt(path, delimiter=",", skiprows=1)
    np.testing.assert_array_equal(recording.samples, truth[:, 1:].T)
    assert (recording.rate, recording.valid.all(), recording.gaps) == (256.0, True, ())
    assert [c.unit for c in recording.channels] == ["m", "m/s^2"]


@pytest.mark.parametrize(
    ("name", "rate", "rows"),
    [("1", 100, 11886), ("2", 100, 11761), ("3_glitches", 100, 8286), ("4_small", 200, 25014)],
)
def test_the_spring_discs_computed_channels_are_left_out(name: str, rate: float, rows: int) -> None:
    recording = read_file(data_folder() / "spring_disc" / f"release_{name}.csv")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m")]
    assert recording.samples.shape == (1, rows)
    assert recording.valid.all()
    assert recording.rate == pytest.approx(rate, rel=1e-9)
    assert "'velocity' was left out" in said(recording)
    assert "'acceleration' was left out" in said(recording)


@pytest.mark.parametrize(
    ("current", "rows"), [("000", 4985), ("100", 1590), ("200", 709), ("400", 241), ("700", 98)]
)
def test_the_wheel_is_an_angle_on_a_slightly_uneven_clock(current: str, rows: int) -> None:
    path = data_folder() / "pohl_wheel" / f"brake_{current}mA.csv"
    for resample in (False, True):
        recording = read_file(path, ImportOptions(resample=resample))
        assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
        assert recording.samples.shape == (1, rows)
        assert recording.rate == pytest.approx(10.0, abs=1e-3)
        assert "column 4 'Weg &b_A1 / rad' read as displacement in rad" in said(recording)
        assert "stray by 0.5" in said(recording) or "stray by 0.4" in said(recording)


@pytest.mark.parametrize(("name", "rows"), [("21337", 9166), ("21338", 19464)])
def test_the_ships_roll_must_be_chosen(name: str, rows: int) -> None:
    path = data_folder() / "ship_roll" / f"model_test_{name}.csv"
    with pytest.raises(ImportProblem, match="'phi'"):
        read_file(path)
    recording = read_file(path, ImportOptions(columns={"displacement": "phi"}, units={"displacement": "rad"}))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    assert recording.samples.shape == (1, rows)
    assert recording.rate == pytest.approx(100.0, rel=1e-6)


def test_the_silverbox_takes_names_units_and_a_rate() -> None:
    path = data_folder() / "silverbox" / "SNLS80mV.mat"
    with pytest.raises(ImportProblem, match="'V2'"):
        read_file(path)
    options = ImportOptions(
        columns={"force": "V1", "displacement": "V2"}, units={"force": "V", "displacement": "V"}, rate=610.35
    )
    recording = read_file(path, options)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "V"), ("force", "V")]
    assert recording.samples.shape == (2, 131072)
    assert recording.valid.all()
