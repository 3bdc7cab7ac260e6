"""Every real recording beside the repository imports, and means what its owner says."""

import numpy as np
import pytest
from import_files import data_folder, said

from daq.importing import ImportOptions, ImportProblem, read_file, read_runs


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


PENDULUMS = {"pendulum_in_air": (1656, 1833, 1646), "pendulum_in_water": (1365, 1640, 2535)}


@pytest.mark.parametrize("name", PENDULUMS)
def test_three_filmed_releases_stand_side_by_side_in_degrees_with_rounded_times(name: str) -> None:
    runs = read_runs(data_folder() / "labelled" / f"{name}.csv")
    assert [r.run for r in runs] == ["1", "2", "3"]
    assert tuple(r.samples.shape[1] for r in runs) == PENDULUMS[name]
    for recording, released in zip(runs, (14.0, 10.0, 6.0), strict=True):
        assert recording.rate == pytest.approx(30.0, rel=1e-9)  # the camera's
        assert [(c.quantity, c.unit) for c in recording.channels] == [
            ("displacement", "rad")
        ]  # omega is computed
        assert np.degrees(np.abs(recording.samples[0][:40]).max()) == pytest.approx(released, abs=0.9)
        assert recording.valid.all()


def test_the_pendulum_at_a_large_angle_is_in_radians() -> None:
    recording = read_file(data_folder() / "labelled" / "pendulum_large_angle.csv")
    assert recording.samples.shape == (1, 13604)
    assert recording.samples[0, 0] == pytest.approx(1.6441, abs=1e-4)
    assert recording.rate == pytest.approx(13603 / (170.255 - 33.692), rel=1e-5)


@pytest.mark.parametrize(("name", "rows"), [("shorted", 30608), ("10kohm", 24160)])
def test_the_magnets_acceleration_loses_its_gravity(name: str, rows: int) -> None:
    recording = read_file(data_folder() / "labelled" / f"magnet_coil_{name}.csv")
    assert recording.samples.shape == (1, rows)
    assert recording.rate == pytest.approx(800.0, rel=1e-6)
    assert abs(recording.samples.mean()) < 0.02
    assert "gravity" in said(recording)


@pytest.mark.parametrize(
    ("name", "rows"), [("alone", 1182), ("pendulum_free", 879), ("pendulum_locked", 1000)]
)
def test_the_phone_on_the_tower_gives_the_axis_that_moves(name: str, rows: int) -> None:
    path = data_folder() / "labelled" / f"tower_{name}.txt"
    recording = read_file(path)
    numbers = np.loadtxt(path, comments="#")
    assert recording.samples.shape == (1, rows)
    assert recording.rate == pytest.approx(1000.0 / numbers[1:, 3].mean(), rel=1e-3)
    np.testing.assert_allclose(recording.samples[0], numbers[:, 0] - np.median(numbers[:, 0]), atol=1e-12)


@pytest.mark.parametrize(("name", "rows"), [("with", 1084), ("without", 1830)])
def test_the_water_gauge_is_its_column_that_moves_in_counts(name: str, rows: int) -> None:
    recording = read_file(data_folder() / "labelled" / f"water_gauge_{name}_damper.txt")
    assert recording.samples.shape == (1, rows)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "count")]
    assert np.ptp(recording.samples) > 400.0
    assert "run A was left out" in said(recording)


def test_the_driven_wheel_is_one_angle() -> None:
    recording = read_file(data_folder() / "labelled" / "wheel_driven_200mA.csv")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    assert recording.rate == pytest.approx(10.0, abs=1e-3)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_encoder_gives_degrees_at_the_rate_above_its_numbers(number: int) -> None:
    path = data_folder() / "rigs" / f"pendulum_encoder_{number}.txt"
    recording = read_file(path)
    assert recording.rate == 1000.0
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    np.testing.assert_allclose(recording.samples[0], np.radians(np.loadtxt(path, skiprows=2)))


def test_the_filmed_bob_becomes_an_angle() -> None:
    recording = read_file(data_folder() / "rigs" / "pendulum_filmed.txt")
    assert recording.samples.shape == (1, 9944)
    assert recording.rate == pytest.approx(30.0, rel=1e-3)
    assert np.degrees(np.abs(recording.samples).max()) == pytest.approx(34.4, abs=0.2)


@pytest.mark.parametrize("name", ["hammer_1", "hammer_2", "hammer_3", "magnet_hammer_1", "magnet_hammer_2"])
def test_the_beam_is_a_velocity_alone(name: str) -> None:
    recording = read_file(data_folder() / "rigs" / f"beam_{name}.txt")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("velocity", "m/s")]
    assert (recording.rate, recording.samples.shape) == (pytest.approx(1e4, rel=1e-9), (1, 100_000))


@pytest.mark.parametrize("name", ["ten_runs", "magnet_free"])
def test_ten_torsion_runs_are_ten_recordings_of_one_angle(name: str) -> None:
    runs = read_runs(data_folder() / "rigs" / f"torsion_{name}.csv")
    assert [r.run for r in runs] == [str(i) for i in range(1, 11)]
    for recording in runs:
        assert recording.rate == pytest.approx(20.0, rel=1e-6)
        assert [(c.name, c.unit) for c in recording.channels] == [("Angle, Ch 1+2 (rad)", "rad")]
        assert np.count_nonzero(~recording.valid) <= 1


@pytest.mark.parametrize(
    ("name", "rows"),
    [("000mA", 3835), ("100mA", 1781), ("200mA", 868), ("400mA", 314), ("10g", 856), ("20g", 273)],
)
def test_the_second_wheel_needs_no_options(name: str, rows: int) -> None:
    recording = read_file(data_folder() / "rigs" / f"wheel2_{name}.txt")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    assert (recording.rate, recording.samples.shape) == (pytest.approx(10.0, rel=1e-9), (1, rows))


def test_the_ship_under_way_is_refused_with_the_column_to_choose() -> None:
    path = data_folder() / "rigs" / "ship_15_knots.csv"
    with pytest.raises(ImportProblem) as refusal:
        read_file(path)
    assert refusal.value.options == ("--column displacement=phi",)
    recording = read_file(path, ImportOptions(columns={"displacement": "phi"}))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]


def test_the_friction_damper_is_read_after_the_units_that_its_json_states() -> None:
    recording = read_file(data_folder() / "rigs" / "friction_damper_forced.json")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m"), ("force", "N")]
    assert (recording.rate, recording.samples.shape) == (1024.0, (2, 10241))
    assert recording.samples[0].max() == pytest.approx(0.932879 * 0.0254, rel=1e-5)
    assert recording.samples[1].max() == pytest.approx(1433.77319 * 4.4482216152605, rel=1e-5)
