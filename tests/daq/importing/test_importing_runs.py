"""Several releases in one file become a recording each, however the file names them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, RATE, load, refusal, said, swing, write

import daq
from daq.importing import ImportOptions, ImportProblem, Recipe, read_file, read_runs
from daq.recording import Array


def wide(
    header: str, columns: Sequence[Array], delimiter: str = ";", comma: bool = False, form: str = "%.9g"
) -> str:
    """Return a table whose columns may end before the others."""
    rows = max(len(c) for c in columns)
    cells = [[form % c[i] if i < len(c) else "" for c in columns] for i in range(rows)]
    text = "\n".join(delimiter.join(row) for row in cells)
    return f"{header}\n{text.replace('.', ',') if comma else text}\n"


def releases(lengths: Sequence[int]) -> list[tuple[Array, Array]]:
    """Return time and displacement of releases from 20 mm and ever less."""
    return [(t, x * (1.0 - 0.07 * i)) for i, n in enumerate(lengths) for t, x, _, _ in [swing(n)]]


LENGTHS = (200, 170, 185)
FORMS = {
    "numbers": ("t1;x1;t2;x2;t3;x3", ["1", "2", "3"]),
    "numbers with units": ("t_1 (s);x_1 (m);t_2 (s);x_2 (m);t_3 (s);x_3 (m)", ["1", "2", "3"]),
    "a word": ("Time (s) Run #1;Position (m) Run #1;Time (s) Run #2;Position (m) Run #2;Time (s) Run #3;Position (m) Run #3",
               ["1", "2", "3"]),
    "a word in front": ("Run 1: Time (s);Run 1: Position (m);Run 2: Time (s);Run 2: Position (m);Run 3: Time (s);"
                        "Run 3: Position (m)", ["1", "2", "3"]),
    "a German word": ("Zeit Messung 4 / s;Weg Messung 4 / m;Zeit Messung 5 / s;Weg Messung 5 / m;Zeit Messung 6 / s;"
                      "Weg Messung 6 / m", ["4", "5", "6"]),
    "repeated names": ("t;x;t;x;t;x", ["1", "2", "3"]),
    "names as pandas repeats them": ("t;x;t.1;x.1;t.2;x.2", ["1", "2", "3"]),
    "no names": ("", ["1", "2", "3"]),
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("delimiter", "comma"), [(";", True), ("\t", False), (",", False)])
def test_each_run_has_its_own_time_and_length(tmp_path: Path, form: str, delimiter: str, comma: bool) -> None:
    header, names = FORMS[form]
    made = releases(LENGTHS)
    text = wide(header.replace(";", delimiter), [c for pair in made for c in pair], delimiter, comma)
    options = {"columns": {"displacement": "none"}} if not header else {}
    if options:  # nothing says what a nameless column is: each run is refused alike
        assert "--column displacement=" in refusal(tmp_path, text)
        return
    runs = read_runs(write(tmp_path, text))
    assert [r.run for r in runs] == names
    for recording, (t, x) in zip(runs, made, strict=True):
        assert recording.rate == pytest.approx(RATE, rel=1e-9)
        assert recording.samples.shape == (1, len(t))
        np.testing.assert_allclose(recording.samples[0], x, rtol=1e-8, atol=1e-12)


def test_columns_of_a_run_may_stand_in_any_order(tmp_path: Path) -> None:
    (t, x), (_, y) = releases((200, 200))
    text = wide("x2 [mm];x1 [mm];t1 [s];t2 [s]", [1e3 * y, 1e3 * x, t, t])
    first, second = read_runs(write(tmp_path, text))
    assert (first.run, second.run) == ("2", "1")
    np.testing.assert_allclose(first.samples[0], y, rtol=1e-8, atol=1e-12)
    np.testing.assert_allclose(second.samples[0], x, rtol=1e-8, atol=1e-12)


def test_twelve_runs_keep_their_numbers_and_one_is_chosen(tmp_path: Path) -> None:
    made = releases([150 + 5 * (i % 4) for i in range(12)])
    header = "\t".join(f'"Time (ms) Run #{i}"\t"Displacement (mm) Run #{i}"' for i in range(1, 13))
    columns = [c for t, x in made for c in (1e3 * t, 1e3 * x)]
    path = write(tmp_path, wide(header, columns, "\t"))
    assert [r.run for r in read_runs(path)] == [str(i) for i in range(1, 13)]
    eleventh = read_file(path, ImportOptions(run=11))
    np.testing.assert_allclose(eleventh.samples[0], made[10][1], rtol=1e-8, atol=1e-12)
    assert refusal(tmp_path, path.read_bytes(), run="13").startswith("a.csv: has no run '13'")
    assert "name one, as in --run 1" in refusal(tmp_path, path.read_bytes())


@pytest.mark.parametrize(("unit", "factor"), [("cm", 100.0), ("mm", 1000.0), ("deg", 180.0 / np.pi)])
def test_the_unit_before_the_number_of_the_only_run_counts(tmp_path: Path, unit: str, factor: float) -> None:
    ((t, x),) = releases((200,))
    quantity = "Angle" if unit == "deg" else "Position"
    found = read_file(
        write(tmp_path, wide(f"Time (ms) Run #1;{quantity} ({unit}) Run #1", [1e3 * t, factor * x]))
    )
    np.testing.assert_allclose(found.samples[0], x, rtol=1e-8, atol=1e-12)


def test_missing_values_within_a_run_are_lost_and_those_after_it_are_not(tmp_path: Path) -> None:
    (t, x), (u, y) = releases((200, 120))
    x = x.copy()
    x[50] = np.nan
    first, second = read_runs(write(tmp_path, wide("t1,x1,t2,x2", [t, x, u, y], ",").replace("nan", "")))
    assert np.flatnonzero(~first.valid).tolist() == [50]
    assert second.valid.all()
    assert second.samples.shape == (1, 120)


def test_one_time_serves_all_runs_where_a_word_says_that_they_are_runs(tmp_path: Path) -> None:
    (t, x), (_, y) = releases((200, 200))
    runs = read_runs(write(tmp_path, wide("Time (s);Angle Run 1 (deg);Angle Run 2 (deg)", [t, x, y])))
    assert [r.run for r in runs] == ["1", "2"]
    np.testing.assert_allclose(runs[1].samples[0], np.radians(y), rtol=1e-8, atol=1e-12)


def test_two_masses_are_no_runs_unless_the_operator_says_so(tmp_path: Path) -> None:
    (t, x), (_, y) = releases((200, 200))
    text = wide("t;x1;x2", [t, x, y])
    assert "2 columns could be the displacement" in refusal(tmp_path, text)
    assert read_file(write(tmp_path, text), ImportOptions(run=2)).samples[0] == pytest.approx(
        y, rel=1e-8, abs=1e-12
    )


def test_a_column_may_number_the_runs_row_by_row(tmp_path: Path) -> None:
    made = releases(LENGTHS)
    t, x = (np.concatenate(parts) for parts in zip(*made, strict=True))
    number = np.repeat([1.0, 2.0, 3.0], LENGTHS)
    runs = read_runs(write(tmp_path, wide("run,t (s),x (m)", [number, t, x], ",")))
    assert [(r.run, r.samples.shape[1]) for r in runs] == [("1", 200), ("2", 170), ("3", 185)]
    np.testing.assert_allclose(runs[2].samples[0], made[2][1], rtol=1e-8, atol=1e-12)


def test_runs_of_other_names_stand_apart_and_end_early_by_a_recipe(tmp_path: Path) -> None:
    """A spreadsheet with two empty columns between a release and another, each with its own time and name."""
    (t, x), (u, y) = releases((200, 150))
    empty = np.full(200, np.nan)
    text = wide("Timed,With TMD (m/s^2),,,Timed,Without TMD (m/s^2)", [t, x, empty, empty, u, y], ",")
    file = write(tmp_path, text.replace("nan", ""))
    with pytest.raises(ImportProblem, match="2 columns could be the acceleration"):
        read_runs(file)
    fields = [
        {"column": number, "role": role, "run": run}
        for run, first in (("with", 1), ("without", 5))
        for number, role in ((first, "time"), (first + 1, "acceleration"))
    ]
    runs = read_runs(file, recipe=Recipe.model_validate({"fields": fields}))
    assert [r.samples.shape for r in runs] == [(1, 200), (1, 150)]
    np.testing.assert_allclose(runs[1].samples[0], y, rtol=1e-8, atol=1e-12)
    other = wide("Time,Position (m),Time,Temperature", [t, x, t, y], ",")
    assert len(read_runs(write(tmp_path, other))) == 1


def test_a_time_that_begins_again_begins_a_run(tmp_path: Path) -> None:
    made = releases(LENGTHS)
    t, x = (np.concatenate(parts) for parts in zip(*made, strict=True))
    runs = read_runs(write(tmp_path, wide("t (s),x (m)", [t, x], ",")))
    assert [(r.run, r.samples.shape[1]) for r in runs] == [("1", 200), ("2", 170), ("3", 185)]
    np.testing.assert_allclose(runs[1].samples[0], made[1][1], rtol=1e-8, atol=1e-12)


def test_columns_that_are_only_called_runs_are_named_by_a_recipe(tmp_path: Path) -> None:
    (t, x), (_, y) = releases((200, 200))
    file = write(tmp_path, wide("t;run1;run2", [t, x, y]))
    with pytest.raises(ImportProblem, match="nothing says whether column 2"):
        read_runs(file)
    runs = [{"name": f"run{k}", "role": "displacement", "run": f"{k}"} for k in (1, 2)]
    recipe = Recipe.model_validate({"fields": [{"name": "t", "role": "time"}, *runs]})
    np.testing.assert_allclose(read_runs(file, recipe=recipe)[1].samples[0], y, rtol=1e-8, atol=1e-12)


def test_a_channel_that_stands_still_or_repeats_another_is_not_taken(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    still = np.tile([0.0, 0.017], 100)
    names = "t (s);Angle, Ch 3+4 (rad);Angle, Ch 1+2 (rad);Position, Ch 1+2 (m)"
    recording = load(tmp_path, wide(names, [t, still, 50 * x, 1.2 * x], form="%.6f"))
    assert [c.name for c in recording.channels] == ["Angle, Ch 1+2 (rad)"]
    assert "% as much as column 3" in said(recording)
    assert "repeats another column" in said(recording)


def test_a_small_oscillation_beside_a_large_drift_is_not_taken_for_standing_still(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    message = refusal(tmp_path, wide("time,x,phi", [t, 30.0 * t, x], ","))
    assert "--column displacement=phi" in message


def test_angles_without_a_unit_are_degrees_in_all_runs_if_one_swings_far(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    first, second = read_runs(write(tmp_path, wide("t1;theta1;t2;theta2", [t, 700 * x, t, 100 * x])))
    assert np.max(np.abs(first.samples)) == pytest.approx(np.radians(14.0))
    assert np.max(np.abs(second.samples)) == pytest.approx(np.radians(2.0))
    assert "deg was assumed" in said(second)
    kept = ImportOptions(units={"displacement": "rad"})
    assert np.max(
        np.abs(read_file(write(tmp_path, wide("t;theta", [t, 700 * x])), kept).samples)
    ) == pytest.approx(14.0)


def test_a_heading_that_jumps_by_a_turn_is_in_radians(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    psi = np.where(x > 0.0, 6.28, 0.01)
    recording = load(tmp_path, wide("t;psi", [t, psi]))
    assert "degrees" not in said(recording)


def test_the_python_face_reads_one_run_or_all(tmp_path: Path) -> None:
    (t, x), (u, y) = releases((200, 120))
    path = write(tmp_path, wide("t1,x1,t2,x2", [t, x, u, y], ","))
    assert [r.samples.shape[1] for r in daq.read_recordings(path)] == [200, 120]
    assert daq.read_recording(str(path), daq.ImportOptions(run=2)).samples.shape == (1, 120)


def test_stamps_coarser_than_the_sampling_give_even_times_at_the_true_rate(tmp_path: Path) -> None:
    n, rate = 1500, 29.97
    t = np.arange(n) / rate
    theta = 9.0 * np.exp(-0.02 * t) * np.cos(OMEGA / 2 * t) + np.random.default_rng(8).normal(0.0, 0.05, n)
    omega = np.gradient(theta, 1 / rate)
    omega[0] = 0.0
    recording = load(tmp_path, wide("t1;theta1;omega1", [t, theta, omega], form="%.2E"))
    assert abs(recording.rate - rate) < 4 * (recording.rate_std or 0.0) < 0.08
    assert recording.valid.all()
    assert "rounding of the stamps, up to 100 ms" in said(recording)
    assert [c.quantity for c in recording.channels] == [
        "displacement"
    ]  # the velocity is its finite difference


def test_a_frame_that_is_missing_shows_beside_stamps_of_few_digits(tmp_path: Path) -> None:
    kept = np.delete(np.arange(543), (46, 140))
    t = kept / 30.025
    recording = load(tmp_path, wide("t;theta", [t, 40.0 * np.cos(4.0 * t)], form="%.2E"))
    assert np.flatnonzero(~recording.valid).tolist() == [46, 140]
    assert abs(recording.rate - 30.025) < 4.0 * recording.rate_std < 0.2
    even = np.delete(np.arange(400), 133) / 20.0  # multiples of 0.05 s, of which two digits hide none
    recording = load(tmp_path, wide("t;theta", [even, np.cos(4.0 * even)], form="%.2E"))
    assert np.flatnonzero(~recording.valid).tolist() == [133]
    later = load(tmp_path, wide("t;theta", [9.5 + t, np.cos(4.0 * t)], form="%.2E"))
    assert abs(later.rate - 30.025) < 4.0 * later.rate_std


@pytest.mark.parametrize("rate", [25.0, 30.0, 60.0, 33.37])
def test_stamps_of_three_digits_that_repeat_give_the_rate_within_its_error(
    tmp_path: Path, rate: float
) -> None:
    t = np.arange(1365) / rate
    x = 14.0 * np.exp(-0.02 * t) * np.cos(OMEGA / 2 * t)
    recording = load(tmp_path, wide("t;x (deg)", [t, x], form="%.2E"))
    assert abs(recording.rate - rate) <= 4 * (recording.rate_std or 0.0) < 0.4


def test_a_part_is_read_by_the_times_of_the_file(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    recording = load(tmp_path, wide("t (s);x (m)", [t + 33.692, x]), start=34.192, stop=35.0)
    np.testing.assert_allclose(recording.samples[0], x[50:132], rtol=1e-8, atol=1e-12)
    assert "its times go from 33.692 s to 35.682 s" in refusal(
        tmp_path, wide("t (s);x (m)", [t + 33.692, x]), start=0.0, stop=1.0
    )


def test_one_clock_beside_each_of_two_channels_is_one_run(tmp_path: Path) -> None:
    t, x, _, _ = swing()
    text = wide("X_Value;Voltage_0;X_Value;Voltage_1", [t, x, t, 3.0 * x])
    asked = {"columns": {"time": 1, "displacement": 4}, "units": {"time": "s", "displacement": "mm"}}
    np.testing.assert_allclose(load(tmp_path, text, **asked).samples[0], 3e-3 * x, rtol=1e-6, atol=1e-9)
    assert "run" not in refusal(tmp_path, text)
