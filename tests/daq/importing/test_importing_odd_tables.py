"""Phones, cameras and loggers: axes with gravity, x and y of a bob, time steps, settings above the numbers, JSON."""

import json
from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, RATE, load, refusal, said, swing, table, write

from daq.importing import ImportProblem, read_runs
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.reading import look_at
from daq.importing.recipe import Recipe
from daq.recording import Array

GRAVITY = 9.80665


def phone(n: int = 300, moving: int = 0) -> tuple[Array, list[Array]]:
    """Return the moving acceleration and the three axes of a phone that stands nearly upright."""
    noise = np.random.default_rng(7)
    _, _, _, a = swing(n)
    axes = [offset + 0.01 * noise.standard_normal(n) for offset in (0.39, 0.26, 9.74)]
    axes[moving] = axes[moving] + 4.0 * a
    return 4.0 * a, axes


STEPS = np.array([0.0, *np.tile([20.0, 20.0, 20.0, 21.0], 80)])


@pytest.mark.parametrize("separator", [" ", "   ", "\t", ";"])
def test_a_phone_without_names_is_read_by_a_recipe(tmp_path: Path, separator: str) -> None:
    motion, axes = phone(moving=1)
    above = "# X Y Z time_from_previous_sample(ms)\n\n# gravity NOT filtered out"
    text = table(above, *axes, STEPS[:300], delimiter=separator) + "\n\n# Completed @Wed\n"
    recipe = Recipe.model_validate(
        {"fields": [{"column": 2, "role": "acceleration", "zero": "median"},
                    {"column": 4, "role": "time_step", "unit": "ms"}]}
    )  # fmt: skip
    (recording,) = look_at(write(tmp_path, text), recipe=recipe).read().recordings
    assert recording.rate == pytest.approx(1000 / 20.25, rel=1e-3)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("acceleration", "m/s^2")]
    assert np.std(recording.samples[0] - motion) < 0.05
    assert abs(np.median(recording.samples[0])) < 1e-9


@pytest.mark.parametrize(
    "header",
    ["time,ax,ay,az", "Time (s),Acceleration x (m/s^2),Acceleration y (m/s^2),Acceleration z (m/s^2)"],
)
def test_axes_with_names_are_chosen_and_their_offset_goes(tmp_path: Path, header: str) -> None:
    motion, axes = phone(moving=1)
    text = table(header, np.arange(300) / RATE, *axes)
    recording = load(tmp_path, text)
    assert np.std(recording.samples[0] - motion) < 0.05
    kept = load(tmp_path, text, keep_offset=True)
    assert np.median(kept.samples[0]) == pytest.approx(0.26, abs=0.2)
    third = load(tmp_path, text, columns={"acceleration": 4})
    assert abs(np.median(third.samples[0])) < 1e-9


def test_axes_in_g_are_axes_too(tmp_path: Path) -> None:
    motion, axes = phone(moving=2)
    recording = load(
        tmp_path, table("t (s),ax (g),ay (g),az (g)", np.arange(300) / RATE, *(a / GRAVITY for a in axes))
    )
    assert np.std(recording.samples[0] - motion) < 0.05


def test_axes_called_g_are_asked_for(tmp_path: Path) -> None:
    motion, axes = phone(moving=2)
    total = np.sqrt(sum(a**2 for a in axes))
    text = table("time,gFx,gFy,gFz,TgF", np.arange(300) / RATE, *(a / GRAVITY for a in (*axes, total)))
    assert "column 4 'gFz'" in refusal(tmp_path, text)
    recording = load(tmp_path, text, columns={"acceleration": "gFz"}, units={"acceleration": "g"})
    assert np.std(recording.samples[0] - motion) < 0.05


def test_of_a_gyroscope_the_axis_that_turns_is_taken(tmp_path: Path) -> None:
    t, _, v, _ = swing()
    names = ",".join(f"Gyroscope {axis} (rad/s)" for axis in "xyz")
    recording = load(tmp_path, table(f"Time (s),{names},Absolute (rad/s)", t, 0.1 * v, v, 0.0 * v, np.abs(v)))
    assert [(c.name, c.quantity) for c in recording.channels] == [("Gyroscope y (rad/s)", "velocity")]


def test_an_angle_that_stays_zero_beside_a_length_is_not_offered(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    recording = load(tmp_path, table("t,theta,x", t, 0.0 * x, x))
    assert [c.name for c in recording.channels] == ["x"]
    assert any("'theta' moves 0 %" in note for note in recording.notes)


def test_a_column_that_counts_rows_is_not_offered_as_the_motion(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    said = refusal(tmp_path, table("#,t (s),val", np.arange(len(t)), t, x))
    assert "whether column 3 'val' is" in said


@pytest.mark.parametrize("delimiter", ["\t", "  "])
def test_a_hash_above_the_numbers_of_the_rows_is_a_name_and_no_remark(tmp_path: Path, delimiter: str) -> None:
    t, x, _, _ = swing()
    header = delimiter.join(["#", "time(s)", "position(mm)", "remark"])
    text = table(header, 1.0 + 3.0 * np.arange(len(t)), t, 1e3 * x, 0.0 * x, delimiter=delimiter)
    recording = load(tmp_path, text)
    assert [c.name for c in recording.channels] == ["position(mm)"]
    assert recording.rate == pytest.approx(RATE)
    remark = load(tmp_path, table("# t(s)  x(mm)", t, 1e3 * x, 0.0 * x, delimiter="  "))
    assert ([c.name for c in remark.channels], remark.rate) == (["x(mm)"], pytest.approx(RATE))


def test_names_between_commas_stand_above_columns_between_tabs(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    recording = load(tmp_path, table("time (s),x (mm)", t, x, delimiter="\t"))
    assert [(c.name, c.quantity) for c in recording.channels] == [("x (mm)", "displacement")]


def test_counts_beside_a_time_are_a_displacement_in_counts(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    recording = load(tmp_path, table("millis,counts", 1e3 * t, np.round(5e4 * x), form="%.0f"))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "count")]
    assert recording.rate == pytest.approx(RATE)


def test_a_line_with_a_rate_is_no_name_of_a_column(tmp_path: Path) -> None:
    _, x, _, _ = swing()
    recording = load(tmp_path, table("# x in mm\n# 100 Hz", 1e3 * x))
    assert (recording.rate, recording.channels[0].unit) == (100.0, "m")
    message = refusal(tmp_path, table("Sampling frequency = 100 Hz", 1e3 * x))
    assert "--column displacement=1 " in message


def test_the_value_over_x_of_a_labview_file_is_a_time(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    above = "LabVIEW Measurement\nSeparator\tTab\n***End_of_Header***\nX_Value\tPosition (mm)\tComment"
    recording = load(tmp_path, table(above, t, 1e3 * x, delimiter="\t"), "a.lvm")
    assert recording.rate == pytest.approx(RATE)


def test_axes_that_move_alike_are_not_guessed(tmp_path: Path) -> None:
    _, axes = phone()
    axes[1] = axes[1] + (axes[0] - 0.39)
    assert "--column acceleration=" in refusal(tmp_path, table("t,ax,ay,az", np.arange(300) / RATE, *axes))


def test_an_axis_that_swings_about_gravity_loses_it_and_a_mean_within_the_swing_stays(tmp_path: Path) -> None:
    t, _, _, a = swing(260)  # two periods and more
    held = load(tmp_path, table("Time (s),Ay (m/s²)", t, a + 9.79))
    assert np.median(held.samples[0]) == pytest.approx(0.0, abs=1e-9)
    assert "gravity" in said(held)
    free = load(tmp_path, table("Time (s),Ay (m/s²)", t, a + 0.5))
    np.testing.assert_allclose(free.samples[0], a + 0.5, rtol=1e-8, atol=1e-8)


def angle(n: int = 400) -> tuple[Array, Array]:
    """Return the time and the angle of a swing of 0.5 rad, 30 frames a second."""
    t = np.arange(n) / 30.0
    return t, 0.5 * np.exp(-0.02 * t) * np.cos(OMEGA / 3 * t)


@pytest.mark.parametrize("header", ["", "t,x,y", "frame time (s),x (m),y (m)"])
def test_x_and_y_of_a_bob_become_its_angle(tmp_path: Path, header: str) -> None:
    t, phi = angle()
    recording = load(tmp_path, table(header, t, 1.18 * np.sin(phi), -1.18 * np.cos(phi)))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
    np.testing.assert_allclose(recording.samples[0], phi, atol=1e-7)
    assert "atan2(x, -y)" in said(recording)


def test_a_picture_whose_y_counts_downwards_gives_the_same_angle(tmp_path: Path) -> None:
    t, phi = angle()
    recording = load(tmp_path, table("t,x,y", t, 300 * np.sin(phi), 300 * np.cos(phi)))
    np.testing.assert_allclose(recording.samples[0], phi, atol=1e-6)


def test_the_pivot_is_found_where_the_origin_is_elsewhere_and_the_columns_are_named(tmp_path: Path) -> None:
    t, phi = angle()
    text = table("t,x,y", t, 4.0 + 1.2 * np.sin(phi), 2.0 - 1.2 * np.cos(phi))
    recording = load(tmp_path, text, angle_from=("x", "y"))
    np.testing.assert_allclose(recording.samples[0], phi, atol=1e-5)
    assert "pivot at x = 4, y = 2" in said(recording)
    numbered = load(tmp_path, text, angle_from=("2", "3"))
    np.testing.assert_array_equal(numbered.samples, recording.samples)
    np.testing.assert_array_equal(load(tmp_path, text, accept=True).samples, recording.samples)


@pytest.mark.parametrize("loose", [0.0, 0.008])
def test_an_arc_about_a_pivot_elsewhere_is_only_proposed(tmp_path: Path, loose: float) -> None:
    t, phi = angle()
    length = 1.2 * (1.0 + loose * np.sin(37.0 * t))
    text = table("t,x,y", t, 4.0 + length * np.sin(phi), 2.0 - length * np.cos(phi))
    assert "could be the displacement" in refusal(tmp_path, text)
    assert "--angle-from x,y" in refusal(tmp_path, text)
    np.testing.assert_allclose(load(tmp_path, text, accept=True).samples[0], phi, atol=0.02)


def test_a_drive_and_what_it_drives_are_no_bob(tmp_path: Path) -> None:
    """A circle of the drive's size fits them as well as any other two columns, and no better than a level line."""
    t = np.arange(400) / 20.0
    driven = 0.05 * np.sin(t - 1.2) + 0.015 * np.sin(5.1 * t) * np.exp(-0.1 * t)
    assert "arc" not in refusal(tmp_path, table("t,x,y", t, 25.0 * np.sin(t), driven))


def test_a_small_swing_is_read_along_x(tmp_path: Path) -> None:
    t, phi = angle()
    x, y = 4.0 + 1.2 * np.sin(0.1 * phi), 2.0 - 1.2 * np.cos(0.1 * phi)
    recording = load(tmp_path, table("t,x,y", t, x, y))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m")]
    np.testing.assert_allclose(recording.samples[0], x, atol=1e-8)


def test_a_mass_on_a_spring_in_a_video_is_read_along_the_axis_that_it_moves_along(tmp_path: Path) -> None:
    t, phi = angle()
    x = 1.0 + 0.02 * np.sin(0.7 * t) + 0.01 * np.random.default_rng(6).standard_normal(len(t))
    recording = load(tmp_path, "mass_A\n" + table("t (s),x (cm),y (cm)", t, x, 24.0 * phi))
    np.testing.assert_allclose(recording.samples[0], 0.24 * phi, atol=1e-8)
    assert "'x (cm)' moves" in said(recording)


def test_points_of_a_video_in_json_give_the_angle_about_their_pivot(tmp_path: Path) -> None:
    t, phi = angle()
    points = [
        {"t": float(a), "x": round(504.2 + 435 * np.sin(b), 3), "y": round(42.0 + 435 * np.cos(b), 3), "confidence": 1}
        for a, b in zip(t, phi, strict=True)
    ]  # fmt: skip
    text = json.dumps({"fps": 30, "pivot": {"x": 504.2, "y": 42.0}, "points": points})
    assert "--angle-from x,y" in refusal(tmp_path, text, "a.json")
    recording = load(tmp_path, text, "a.json", accept=True)
    np.testing.assert_allclose(recording.samples[0], phi, atol=1e-4)


def test_of_two_times_the_operator_chooses_the_clock(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    lasting = 10.0 + np.round(3.0 * np.sin(7.0 * t))
    text = table("X (mm),Istante (ms),Durata (ms)", 1e3 * x, 1e3 * t, lasting)
    assert "2 columns could be the time: column 2 'Istante (ms)', column 3" in refusal(tmp_path, text)
    assert load(tmp_path, text, columns={"time": 2}).rate == pytest.approx(100.0)
    assert load(tmp_path, text, accept=True).rate == pytest.approx(100.0)


def test_momentum_is_no_force_and_makes_no_angle(tmp_path: Path) -> None:
    t, x, v, _ = swing()
    text = table("time,x-position,velocity,momentum,kinetic energy", t, x, v, 2 * v, v * v)
    recording = load(tmp_path, text, keep_derived=True)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m"), ("velocity", "m/s")]


def test_one_column_that_nothing_names_is_asked_for_in_words(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    assert "nothing says whether column 2 is a displacement" in refusal(tmp_path, table("", t, x))


def test_x_and_y_that_lie_on_no_arc_are_not_an_angle(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    text = table("t,x,y", t, x, 0.3 * np.roll(x, 40))
    assert "could be the displacement" in refusal(tmp_path, text)
    assert "do not lie on an arc" in refusal(tmp_path, text, angle_from=("x", "y"))


@pytest.mark.parametrize(
    "line",
    ["Sampling rate: 100 Hz", "# dt = 0.01 s", "Sample interval: 10 ms", "Abtastrate 0.1 kHz", "fps: 100",
     "100 frames per second", "Rate: 100 Hz"],
)  # fmt: skip
def test_the_rate_is_read_from_a_line_above(tmp_path: Path, line: str) -> None:
    _, x, _, _ = swing()
    assert load(tmp_path, table(f"{line}\nx (mm)", 1e3 * x)).rate == pytest.approx(100.0)


def test_a_column_of_time_steps_needs_a_recipe(tmp_path: Path) -> None:
    _, x, _, _ = swing()
    assert "time_step" in refusal(tmp_path, table("x (m),dt (s)", x, 0.01 + 0.001 * (np.arange(200) % 2)))


def test_a_velocity_is_enough(tmp_path: Path) -> None:
    t, _, v, _ = swing()
    above = (
        "Source File Name:\tt3\nSignal:\tTime - Vib Velocity - Samples\n\nTime\tTime Signal\n[ s ]\t[ m/s ]"
    )
    recording = load(tmp_path, table(above, t, v, delimiter="\t"))
    assert [(c.quantity, c.unit) for c in recording.channels] == [("velocity", "m/s")]


T, X, V, A = swing()
ROWS = np.column_stack([T, 1e3 * X]).tolist()
JSON = {
    "keys with points": {"a.b": {"c": {"d.e": {"t (s)": T.tolist(), "x (mm)": (1e3 * X).tolist()}}}, "a": 1},
    "a very long key": {"k" * 300: {"t (s)": T.tolist(), "x (mm)": (1e3 * X).tolist()}},
    "rows with a header": [["t (s)", "x (mm)"], *ROWS],
    "records": [{"t (s)": t, "x (mm)": x} for t, x in ROWS],
    "columns": {"t (s)": T.tolist(), "x (mm)": (1e3 * X).tolist(), "rig": "spring"},
    "columns and a rate": {"meta": {"sample rate": 100}, "signals": {"x (mm)": (1e3 * X).tolist()}},
    "columns and a step": {"dt": 0.01, "x": (1e3 * X).tolist(), "units": {"x": "mm"}},
}


@pytest.mark.parametrize("form", JSON)
def test_json_is_a_table_too(tmp_path: Path, form: str) -> None:
    recording = load(tmp_path, json.dumps(JSON[form]), "a.json")
    assert recording.rate == pytest.approx(100.0)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m")]
    np.testing.assert_allclose(recording.samples[0], X, rtol=1e-9, atol=1e-12)


RUNS = {
    "a list": {"runs": [{"t": T.tolist(), "x": X.tolist()}, {"t": T[:90].tolist(), "x": V[:90].tolist()}]},
    "keys": {
        "run4": {"t": T.tolist(), "x": X.tolist()},
        "run7": {"t": T[:90].tolist(), "x": V[:90].tolist()},
    },
}


@pytest.mark.parametrize(("form", "key"), [("a list", "runs.2"), ("keys", "run7")])
def test_of_several_tables_in_json_the_largest_is_read_and_a_recipe_names_another(
    tmp_path: Path, form: str, key: str
) -> None:
    (largest,) = read_runs(write(tmp_path, json.dumps(RUNS[form]), "a.json"))
    np.testing.assert_array_equal(largest.samples[0], X)
    assert f"not read: the table under '{key}'" in said(largest)
    fields = [{"name": "t", "role": "time"}, {"name": "x", "role": "displacement"}]
    recipe = Recipe.model_validate({"fields": fields, "dialect": {"property": key}})
    (other,) = look_at(tmp_path / "a.json", recipe=recipe).read().recordings
    np.testing.assert_array_equal(other.samples[0], V[:90])


def test_json_of_a_record_a_line_and_of_channels_is_read(tmp_path: Path) -> None:
    lines = "\n".join(json.dumps({"t (s)": t, "x (mm)": x}) for t, x in ROWS)
    np.testing.assert_allclose(load(tmp_path, lines, "a.jsonl").samples[0], X, rtol=1e-9, atol=1e-12)
    channels = {"fs": 100, "channels": [{"name": "pos", "unit": "mm", "values": (1e3 * X).tolist()}]}
    np.testing.assert_allclose(
        load(tmp_path, json.dumps(channels), "a.json").samples[0], X, rtol=1e-9, atol=1e-12
    )


@pytest.mark.parametrize(
    ("keys", "unit", "label"),
    [
        (("name", "unit"), "mm", "x (mm)"), (("name", "unit"), None, "x"), (("name", "unit"), "", "x"),
        (("label", "units"), "mm", "x (mm)"), (("Name", "Unit"), "mm", "x (mm)"), (("Label", "Units"), "mm", "x (mm)"),
    ],
)  # fmt: skip
def test_json_channels_name_themselves_and_their_units_by_any_of_the_usual_keys(
    tmp_path: Path, keys: tuple[str, str], unit: str | None, label: str
) -> None:
    name, of = keys
    channels = [{name: "t", of: "s", "data": T.tolist()}, {name: "x", of: unit, "data": X.tolist()}]
    recording = load(tmp_path, json.dumps({"channels": channels}), "a.json")
    assert [channel.name for channel in recording.channels] == [label]
    np.testing.assert_allclose(recording.samples[0], X * (1e-3 if unit else 1.0), rtol=1e-9, atol=1e-12)


def test_json_with_null_loses_a_sample_and_json_without_numbers_is_refused(tmp_path: Path) -> None:
    rows = [[t, None if i == 7 else 0.01 * x] for i, (t, x) in enumerate(ROWS)]
    recording = load(tmp_path, json.dumps({"data": [["t", "x"], *rows]}), "a.json")
    assert np.flatnonzero(~recording.valid).tolist() == [7]
    assert "holds no table of numbers" in refusal(tmp_path, '{"a": [1, 2], "b": "text"}', "a.json")
    assert "cannot be read" in refusal(tmp_path, '{"a": [1, 2', "a.json")


def test_a_plots_x_that_rises_evenly_is_the_time_and_y_the_motion(tmp_path: Path) -> None:
    t, u, _, _ = swing(150, 12.0)
    noise = np.full(150, 0.004)
    recording = load(tmp_path, table("X,Y,X',Y'", np.round(t, 3), u, noise, noise))
    assert recording.rate == pytest.approx(12.0, rel=1e-4)
    np.testing.assert_allclose(recording.samples[0], u, rtol=1e-7)
    assert "rise evenly" in said(recording)


def test_an_x_that_swings_is_still_a_motion(tmp_path: Path) -> None:
    _, u, _, _ = swing(150)
    recording = load(tmp_path, table("x,n", u, np.ones(150)), rate=100.0)
    np.testing.assert_allclose(recording.samples[0], u, rtol=1e-7)


def test_with_a_rate_it_does_not_matter_which_of_two_columns_is_the_time(tmp_path: Path) -> None:
    t, u, _, _ = swing(150)
    text = table("Timestamp,Time_Elapsed(s),Angle(deg)", t + 1e5, t, u * 100.0)
    assert "--column 'time=" in refusal(tmp_path, text) or "--column time=" in refusal(tmp_path, text)
    recording = load(tmp_path, text, rate=100.0)
    assert recording.rate == 100.0
    np.testing.assert_allclose(recording.samples[0], np.radians(u * 100.0), rtol=1e-7)


def test_rows_that_are_counted_from_any_number_are_no_clock(tmp_path: Path) -> None:
    _, x, _, _ = swing(300)
    text = "".join(f"{1000 + i},{1e3 * b:.3f}\n" for i, b in enumerate(x))
    asked = {"columns": {"displacement": 2}, "units": {"displacement": "mm"}}
    assert "names no rate" in refusal(tmp_path, text, **asked)
    assert load(tmp_path, text, rate=100.0, **asked).rate == 100.0


def test_json_of_a_list_for_each_axis_is_transposed(tmp_path: Path) -> None:
    motion, axes = phone(230)
    asked = {"rate": 30.0, "columns": {"acceleration": 1}, "units": {"acceleration": "m/s^2"}}
    recording = load(tmp_path, json.dumps([list(axis) for axis in axes]), **asked)
    assert recording.samples.shape == (1, 230)
    assert np.std(recording.samples[0] - motion) < 0.05


def test_without_names_the_only_column_that_rises_evenly_is_the_time_wherever_it_stands(
    tmp_path: Path,
) -> None:
    t, u, _, _ = swing(300)
    uneven = t + 1e-4 * np.random.default_rng(2).random(300)
    text = table("", 40.0 * u / np.max(np.abs(u)), np.round(2.4 + uneven, 3), 90.0 * u, delimiter=",")
    with pytest.raises(ImportProblem) as caught:
        load(tmp_path, text)
    assert "column 1, column 3" in str(caught.value)
    assert "--rate" not in str(caught.value)
    recording = load(tmp_path, text, columns={"displacement": 1}, units={"displacement": "deg"})
    assert recording.rate == pytest.approx(RATE, rel=1e-3)
    assert "column 2 is not named as a time, but its numbers rise evenly" in said(recording)


def test_a_column_that_stands_still_is_no_motion_to_choose(tmp_path: Path) -> None:
    t, u, _, _ = swing(300)
    with pytest.raises(ImportProblem, match="whether column 3 is a displacement"):
        load(tmp_path, table("", t, np.zeros(300), u, delimiter="\t"))


def test_a_table_of_amplitudes_is_told_that_it_is_no_recording(tmp_path: Path) -> None:
    times = np.array([0.0, 3.9, 10.0, 16.9, 23.8, 30.6, 37.4, 43.5, 50.3, 57.0, 63.8])
    recording = load(tmp_path, table("t,theta (rad)", times, 0.25 * np.exp(-times / 17.0)))
    assert "11 samples only: the amplitudes or periods of swings are no recording" in said(recording)
    assert "the motion's period" not in said(recording)


@pytest.mark.parametrize("names", ["roll_deg,pitch_deg,yaw_deg", "phi (deg),theta (deg),psi (deg)"])
def test_of_the_angles_of_one_body_the_one_that_it_swings_by_is_taken(tmp_path: Path, names: str) -> None:
    t, u, _, _ = swing(300)
    noise = 0.01 * np.random.default_rng(5).standard_normal((2, 300))
    recording = load(tmp_path, table(f"t (s),{names}", t, noise[0], 500.0 * u, noise[1]))
    assert recording.samples[0] == pytest.approx(np.radians(500.0 * u), abs=1e-4)
    assert "% as much as column" in said(recording)


def test_angles_of_one_body_that_move_alike_are_for_the_operator_to_choose(tmp_path: Path) -> None:
    t, u, _, _ = swing(300)
    assert "2 columns could be the displacement" in refusal(
        tmp_path, table("t (s),roll (deg),pitch (deg)", t, u, 0.5 * u[::-1])
    )


@pytest.mark.parametrize(("scale", "unit"), [(40000.0, "count"), (5000.0, "rad")])
def test_whole_numbers_of_an_encoder_beyond_a_turn_are_counts(
    tmp_path: Path, scale: float, unit: str
) -> None:
    t, u, _, _ = swing(300)
    recording = load(tmp_path, table("t (s),encoder", t, np.rint(scale * u)))
    assert recording.channels[0].unit == unit


def test_a_column_called_ts_is_the_time(tmp_path: Path) -> None:
    t, _, _, a = swing(300)
    rows = [{"ts": 1690000000000 + round(1000.0 * x), "acc": y} for x, y in zip(t, a, strict=True)]
    recording = load(tmp_path, "".join(json.dumps(row) + "\n" for row in rows), "a.jsonl")
    assert recording.rate == pytest.approx(RATE, rel=1e-3)


@pytest.mark.parametrize(("loss", "rest"), [(2.0, 0.0), (2.0, 0.5), (2.5, 0.2), (3.0, 0.2)])
def test_a_command_that_takes_the_angle_is_explained_in_the_sentence(
    tmp_path: Path, loss: float, rest: float
) -> None:
    """Cardboard that bends and stops soon; its first two frames are those of the hand."""
    t = np.arange(130) / 30.0
    phi = 1.2 * np.exp(-loss * t) * np.cos(15.0 * t) + rest
    radius = 0.09 * (1.0 + 0.06 * np.cos(31.0 * t) * np.exp(-loss * t))
    x, y = radius * np.sin(phi), -radius * np.cos(phi)
    x[:2], y[:2] = (0.164, 0.165), (-0.016, -0.009)
    with pytest.raises(Doubtful) as refused:
        load(tmp_path, table("t,x,y", t, x, y))
    offered = any(field.role == "x" for field in refused.value.proposal.recipe.fields)
    assert offered == ("if they are a pendulum's bob" in str(refused.value))


@pytest.mark.parametrize(
    ("header", "unit"),
    [
        ("displacement_mm_raw", "mm"),
        ("displacement_mm_filt_2", "mm"),
        ("position_um_x", "um"),
        ("angle_deg_filtered", "deg"),
        ("displacement_raw", "m"),
    ],
)
def test_a_unit_stands_before_words_that_say_which_reading_it_is(
    tmp_path: Path, header: str, unit: str
) -> None:
    t, phi = angle()
    recording = load(tmp_path, table(f"time_s,{header}", t, phi))
    scale = {"mm": 1e-3, "um": 1e-6, "deg": np.pi / 180.0, "m": 1.0}[unit]
    np.testing.assert_allclose(recording.samples[0], scale * phi, atol=1e-6 * scale)


def test_names_between_blanks_stand_above_a_table_of_tabs(tmp_path: Path) -> None:
    t, phi = angle()
    above = (
        "# run : 2017-Mar-30-run-07\n#  micrometer = not recorded\n#  Time (S)   sum_Signal  LR_Signal\n# \n"
    )
    rows = "\n".join(f"  {a:.6f}\t {b: .6f}\t {c: .6f}" for a, b, c in zip(t, 0.1 * phi, phi, strict=True))
    recording = load(
        tmp_path, above + rows, columns={"displacement": "LR_Signal"}, units={"displacement": "V"}
    )
    np.testing.assert_allclose(recording.samples[0], phi, atol=1e-6)
    assert "'Time (S)' read as time" in said(recording)


def test_the_size_of_a_vector_is_a_motion_where_it_stands_alone(tmp_path: Path) -> None:
    t, u, _, _ = swing(300)
    assert load(tmp_path, table("t (s),absolute angle (deg)", t, u)).channels[0].quantity == "displacement"


def test_a_recipe_says_where_the_table_of_a_json_file_is(tmp_path: Path) -> None:
    other = {"t": list(range(900)), "x": [0.0] * 900, "y": [1.0] * 900}
    text = json.dumps({"log": other, "test": {"rows": {"t": T.tolist(), "x": X.tolist(), "e": V.tolist()}}})
    recipe = Recipe.model_validate(
        {"fields": ({"name": "t", "role": "time"}, {"name": "x", "role": "displacement"}),
         "dialect": {"property": "test.rows"}}
    )  # fmt: skip
    (recording,) = look_at(write(tmp_path, text, "a.json"), recipe=recipe).read().recordings
    np.testing.assert_array_equal(recording.samples[0], X)
    wrong = recipe.model_copy(update={"dialect": recipe.dialect.model_copy(update={"property": "test.none"})})
    with pytest.raises(ImportProblem, match=r"no table of numbers under 'test\.none'"):
        look_at(tmp_path / "a.json", recipe=wrong)


def test_the_end_of_a_name_that_is_no_unit_of_its_quantity_is_part_of_the_name(tmp_path: Path) -> None:
    t, x, _, _ = swing(1000)
    assert "2 columns could be the displacement" in refusal(
        tmp_path, table("time,angle_h,angle", t, 50 * x, 25 * x)
    )


def test_a_column_named_for_a_quantity_that_holds_no_number_is_refused_by_its_name(tmp_path: Path) -> None:
    t, _, v, _ = swing()
    text = table("time,x,v", t, np.full(len(t), np.nan), v)
    told = refusal(tmp_path, text, columns={"displacement": "x"})
    assert "column 2 'x' holds no numbers; name another one" in told


def test_runs_of_one_file_have_one_unit_though_only_one_swings_too_far_for_metres(tmp_path: Path) -> None:
    t, u, _, _ = swing()
    path = tmp_path / "runs.csv"
    path.write_text(table("Time (s),x Run 1,x Run 2", t, 150.0 * u, 500.0 * u))
    assert 150.0 * np.max(np.abs(u)) < 5.0 < 500.0 * np.max(np.abs(u))
    runs = read_runs(path, ImportOptions(accept=True))
    assert [run.channels[0].unit for run in runs] == ["count", "count"]


def test_a_column_of_which_only_an_option_says_what_it_is_has_no_unit(tmp_path: Path) -> None:
    t, u, _, _ = swing()
    text = table("time,cx,x", t, 500.0 + 2e4 * u, 2e4 * u)
    assert load(tmp_path, text, columns={"displacement": "cx"}).channels[0].unit == "count"
    with pytest.raises(
        ImportProblem, match=r"column 3 'x' names no unit and swings by .* too far for metres"
    ):
        load(tmp_path, text, columns={"displacement": "x"})
    assert load(tmp_path, text, columns={"displacement": "x"}, accept=True).channels[0].unit == "count"
    small = table("time,cx,x", t, 500.0 + 2e4 * u, 0.1 * u)
    assert load(tmp_path, small, columns={"displacement": "x"}).channels[0].unit == "m"


def test_a_column_that_counts_its_rows_is_no_time_without_a_unit(tmp_path: Path) -> None:
    _, u, _, _ = swing()
    text = table("frame,cx", np.arange(len(u)), 2e4 * u)
    columns = {"time": "frame", "displacement": "cx"}
    with pytest.raises(ImportProblem, match=r"column 1 'frame' counts its rows.*give --rate HZ"):
        load(tmp_path, text, columns=columns)
    assert load(tmp_path, text, columns=columns, units={"time": "ms"}).rate == pytest.approx(1000.0)
