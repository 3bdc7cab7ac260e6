"""Files that nothing but a recipe explains, each in the form in which a logger or a repository writes it."""

import json
import os
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from import_files import OMEGA, RATE, load, swing, table, write
from scipy.io import savemat

from daq.importing import ImportOptions, ImportProblem
from daq.importing.propose import Doubtful
from daq.importing.reading import look_at
from daq.importing.recipe import Recipe, read_recipe
from daq.recording import Recording

T, X, V, A = swing(300)
FIELD = Path(os.environ.get("STATION_DATA", "")) / "field"


def by(folder: Path, file: Path, recipe: str) -> tuple[Recording, ...]:
    """Read a file by a recipe alone."""
    written = folder / "recipe.toml"
    written.write_text(recipe, encoding="utf-8")
    return look_at(file, recipe=read_recipe(written)).read().recordings


OSCILLOSCOPE = "".join(
    f"{setting},{t:.6f},{1e3 * x:.5f},\n"
    for setting, t, x in zip(
        ["Record Length,300,", "Sample Interval,1e-2,", "Source,CH1,", *[",,"] * 297], T, X, strict=True
    )
)
CHIP = table("millis,ax,ay,az", 1e3 * T, 0.0 * T, 0.0 * T, np.rint(16384 * (1.0 + X)), form="%.0f")
ROLLED = "time,x\n" + "".join(
    f"14:43:{24 + int(max(t - 0.006, 0.0)):02d}.{round(1e3 * (t % 1)) % 1000:03d},{x:.6f}\n"
    for t, x in zip(T, X, strict=True)
)
TIMED = '{column = 1, role = "time", unit = "s"}'
CASES = {
    "an oscilloscope's settings beside its numbers": (OSCILLOSCOPE, """recipe = 1
fields = [{column = 4, role = "time", unit = "s"}, {column = 5, role = "displacement", unit = "mm"}]
dialect = {header = false, delimiter = ","}""", "m", X),
    "the counts of a chip": (CHIP, """recipe = 1
fields = [{name = "millis", role = "time", unit = "ms"},
  {name = "az", role = "acceleration", unit = "0.00006103515625 g", zero = 16384}]""", "m/s^2", 9.80665 * X),
    "steps of time without a name": (table("", X, np.full(300, 10.0)), """recipe = 1
fields = [{column = 1, role = "displacement", unit = "m"}, {column = 2, role = "time_step", unit = "ms"}]""", "m", X),
    "a unit among settings": (table("trigger_start_deg, sample_rate\n45, 100", np.degrees(X)), """recipe = 1
rate = 100
fields = [{column = 1, role = "displacement", unit = "deg"}]
dialect = {header = false, commentRows = [1, 2]}""", "rad", X),
    "seconds that were read before the fraction": (ROLLED, """recipe = 1
rate = 100
fields = [{name = "x", role = "displacement", unit = "m"}]""", "m", X),
    "JSON without names": (json.dumps({"data": np.column_stack([T, X]).tolist()}), f"""recipe = 1
fields = [{TIMED}, {{column = 2, role = "displacement", unit = "m"}}]""", "m", X),
    "JSON with names apart": (json.dumps({"keys": ["t", "u"], "rows": np.column_stack([T, X]).tolist()}), f"""recipe = 1
fields = [{TIMED}, {{column = 2, role = "displacement", unit = "m"}}]""", "m", X),
    "names in two rows, a log above": (table("armed\ntime,angle\ns,deg", T, np.degrees(X)), """recipe = 1
fields = [{column = 1, role = "time", unit = "s"}, {column = 2, role = "displacement", unit = "deg"}]
dialect = {header = false, commentRows = [1, 2, 3]}""", "rad", X),
    "remarks of an odd sign": ("? a 1,2\n" + table("t,u", T, X), """recipe = 1
fields = [{name = "t", role = "time"}, {name = "u", role = "displacement", sign = -1}]
dialect = {commentRows = [1]}""", "m", -X),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_what_no_rule_knows_a_recipe_says(tmp_path: Path, name: str) -> None:
    text, recipe, unit, expected = CASES[name]
    (recording,) = by(tmp_path, write(tmp_path, text), recipe)
    assert recording.rate == pytest.approx(RATE, rel=1e-4)
    assert [channel.unit for channel in recording.channels] == [unit]
    np.testing.assert_allclose(recording.samples[0], expected, atol=6e-4 if unit == "m/s^2" else 1e-5)


def test_runs_of_any_names_are_grouped_and_parts_are_cut(tmp_path: Path) -> None:
    file = write(tmp_path, table("Latest: t,Latest: u,Run 1: t,Run 1: u", T, X, T, 2.0 * X))
    runs = """recipe = 1
fields = [
  {name = "Latest: t", role = "time", run = "new"}, {name = "Latest: u", role = "displacement", run = "new"},
  {name = "Run 1: t", role = "time", run = "1"}, {name = "Run 1: u", role = "displacement", run = "1"},
]
"""
    new, first = by(tmp_path, file, runs)
    assert (new.run, first.run) == ("new", "1")
    np.testing.assert_allclose(first.samples[0], 2.0 * X, rtol=1e-8)
    parts = by(tmp_path, file, 'runs = ["1"]\nparts = [{to = 0.99}, {from = 1.5, to = 2.0}]\n' + runs)
    assert [(part.run, part.samples.shape[1]) for part in parts] == [("1.1", 100), ("1.2", 51)]
    np.testing.assert_allclose(parts[1].samples[0], 2.0 * X[150:201], rtol=1e-8)


@pytest.mark.parametrize(
    ("recipe", "said"),
    [
        ('fields = [{name = "t", role = "time"}]', "names no displacement, velocity or acceleration"),
        (
            'fields = [{name = "x", role = "displacement"}, {name = "v", role = "displacement"}]',
            "cannot both be",
        ),
        ('restarts = true\nfields = [{name = "x", role = "displacement"}]', "names no time"),
        ('rate = 9\nruns = ["7"]\nfields = [{name = "x", role = "displacement"}]', "has no run '7'"),
        ('fields = [{name = "x", role = "displacement"}]', "names no rate"),
        ('rate = 9\nfields = [{name = "v", role = "x"}, {name = "t", role = "y"}]', "do not lie on an arc"),
    ],
)
def test_a_recipe_that_does_not_fit_gets_a_sentence(tmp_path: Path, recipe: str, said: str) -> None:
    with pytest.raises(ImportProblem, match=said):
        by(tmp_path, write(tmp_path, table("t,x,v", T, X, V)), recipe)


def proposal(folder: Path, text: str | bytes, name: str = "a.csv") -> tuple[Recipe, str]:
    """Return the recipe that is proposed for a file which leaves doubts, and the sentence."""
    with pytest.raises(Doubtful) as caught:
        look_at(write(folder, text, name)).read()
    return caught.value.proposal.recipe, str(caught.value)


def test_runs_without_any_time_are_runs_and_only_the_rate_is_asked_for(tmp_path: Path) -> None:
    text = table(
        '"Position (mm) Run #1";"Position (mm) Run #2"', 60 + 1e3 * X, 33 + 500 * X, delimiter=";", comma=True
    )
    recipe, sentence = proposal(tmp_path, text)
    assert "names no rate" in sentence
    assert [(field.role, field.run) for field in recipe.fields] == [
        ("displacement", "1"),
        ("displacement", "2"),
    ]
    recordings = look_at(write(tmp_path, text), ImportOptions(rate=RATE)).read().recordings
    np.testing.assert_allclose(recordings[1].samples[0], 1e-3 * (33 + 500 * X), atol=1e-7)


def test_of_a_drive_and_a_motion_without_names_nothing_is_taken_unasked(tmp_path: Path) -> None:
    recipe, sentence = proposal(
        tmp_path, table("", T, 30.0 * np.sin(3.1 * T), X, delimiter="\t", form="%.5f")
    )
    assert "nothing says which column" in sentence
    assert sorted(field.role for field in recipe.fields) == ["displacement", "ignored", "time"]
    assert {field.unit for field in recipe.fields if field.role == "displacement"} == {"counts"}


def test_rows_written_in_bursts_beside_two_clocks_are_asked_for_and_read_at_their_mean_rate(
    tmp_path: Path,
) -> None:
    t = np.arange(2000) / 260.0
    blocks = np.ceil((t + 1e-9) / 0.065) * 0.065
    day = blocks + 0.0007 * (np.arange(2000) % 17)
    rows = (
        f"16:15:{a:06.3f}, {2175 + b:.3f}, {c:.2f}\n"
        for a, b, c in zip(day, blocks, 52 * np.cos(9 * t), strict=True)
    )
    text = "".join(chain(["Timestamp, Time_Elapsed(s), Angle(deg)\n", "-" * 37 + "\n"], rows))
    recipe, sentence = proposal(tmp_path, text)
    assert "many are equal to the one before; if the rows were read evenly" in sentence
    assert recipe.even
    read = load(tmp_path, text, accept=True)
    assert read.rate == pytest.approx(260.0, rel=2e-3)
    assert abs(read.rate - 260.0) < 2.0 * read.rate_std < 2.0
    stated = 'rate = 260\nfields = [{name = "Angle(deg)", role = "displacement", unit = "deg"}]'
    (recording,) = by(tmp_path, write(tmp_path, text), stated)
    np.testing.assert_allclose(recording.samples[0], np.radians(52 * np.cos(9 * t)), atol=1e-4)


@pytest.mark.parametrize("loose", [0.0, 0.012])
def test_a_bob_without_names_is_read_or_proposed_as_its_angle(tmp_path: Path, loose: float) -> None:
    phi = 0.7 * np.exp(-0.05 * T) * np.cos(OMEGA * T)
    length = 1.4 * (1.0 + loose * np.sin(37.0 * T))
    text = table("", T, 0.3 + length * np.sin(phi), 0.2 - length * np.cos(phi), delimiter=" ")
    recipe, _ = proposal(tmp_path, text)
    assert [field.role for field in recipe.fields] == ["time", "x", "y"]
    recording = load(tmp_path, text, accept=True)
    np.testing.assert_allclose(recording.samples[0], phi, atol=0.02)


def test_a_way_that_repeats_an_angle_is_not_the_motion(tmp_path: Path) -> None:
    text = table(
        "t / s;Weg s / m;Winkel w / rad", T, 0.11 * np.round(X, 5), np.round(X, 5), delimiter=";", comma=True
    )
    assert [channel.unit for channel in load(tmp_path, text).channels] == ["rad"]


def test_what_follows_a_gap_on_another_clock_is_cut_off_by_a_recipe(tmp_path: Path) -> None:
    t = np.concatenate([np.arange(250) / 30.0, 8.85 + np.arange(50) / 30.4])
    text = table("t,theta (rad)", t, X)
    assert "stray" in proposal(tmp_path, text)[1]
    fields = (
        'fields = [{name = "t", role = "time"}, {name = "theta (rad)", role = "displacement", unit = "rad"}]'
    )
    (recording,) = by(tmp_path, write(tmp_path, text), "parts = [{to = 8.3}]\n" + fields)
    assert recording.rate == pytest.approx(30.0, rel=1e-6)
    np.testing.assert_allclose(recording.samples[0], X[:250], rtol=1e-8)


def test_derivatives_by_name_leave_the_positions_to_be_asked_for(tmp_path: Path) -> None:
    recipe, sentence = proposal(tmp_path, table("ts,Phi,Theta0,dPhi,dTheta0,ddPhi", T, X, 3 * V, V, A, 2 * A))
    assert "2 columns could be the displacement: column 2 'Phi', column 3 'Theta0'" in sentence
    assert [field.name for field in recipe.fields if field.role == "displacement"] == ["Phi"]


def matlab(folder: Path, **variables: object) -> Path:
    """Write variables as MATLAB does."""
    savemat(folder / "a.mat", variables)
    return folder / "a.mat"


def test_a_matlab_file_with_a_rate_of_its_own_name_only_lacks_what_was_measured(tmp_path: Path) -> None:
    file = matlab(tmp_path, ActualRate=np.array([[100]]), duration=np.array([[3]]), data=X[:, None])
    (recording,) = by(tmp_path, file, 'fields = [{name = "data", role = "velocity", unit = "deg/s"}]')
    assert recording.rate == RATE
    np.testing.assert_allclose(recording.samples[0], np.radians(X))


def test_an_even_column_of_a_matlab_matrix_is_the_time(tmp_path: Path) -> None:
    file = matlab(tmp_path, data=np.column_stack([13.84 + T, X]))
    (recording,) = by(
        tmp_path,
        file,
        """fields = [
      {name = "data(:,1)", role = "time", unit = "s"}, {name = "data(:,2)", role = "displacement", unit = "deg"}]""",
    )
    assert recording.rate == pytest.approx(RATE, rel=1e-9)
    with pytest.raises(Doubtful) as caught:
        look_at(file).read()
    assert [field.role for field in caught.value.proposal.recipe.fields] == ["time", "displacement"]


def test_the_members_of_a_structure_array_are_runs_with_their_own_times(tmp_path: Path) -> None:
    members = np.zeros((1, 3), dtype=[("t_corrected", object), ("y_norm", object), ("bar", object)])
    for k in range(3):
        members[0, k] = ((T + 1e-4 * k)[:, None], ((k + 1) * X)[:, None], T[:5, None])
    with pytest.raises(Doubtful) as caught:
        look_at(matlab(tmp_path, T_mean=members)).read()
    recordings = look_at(tmp_path / "a.mat", recipe=caught.value.proposal.recipe).read().recordings
    assert [recording.run for recording in recordings] == ["1", "2", "3"]
    np.testing.assert_allclose(recordings[2].samples[0], 3 * X)


def test_a_file_cut_off_within_a_number_ends_before_it(tmp_path: Path) -> None:
    text = (
        "STARTING CAPTURE...\nBUTTON RELEASED, DUMPING DATA...\n" + table("", 1e4 * np.arange(300), X) + "300"
    )
    (recording,) = by(
        tmp_path,
        write(tmp_path, text),
        """
fields = [{column = 1, role = "time", unit = "us"}, {column = 2, role = "displacement", unit = "V"}]
dialect = {header = false, commentRows = [1, 2]}""",
    )
    assert (recording.samples.shape[1], recording.channels[0].unit) == (300, "V")
    assert recording.rate == pytest.approx(RATE)


def test_another_encoding_and_one_of_two_sensors_on_stamps_that_stray(tmp_path: Path) -> None:
    stamps = np.rint(1e3 * (T + 0.004 * np.sin(np.arange(300.0) ** 2)))
    text = table(
        "Czas [ms]\tPrzyspieszenie eliminatora [m/s^2]\tPrędkość [1/min]", stamps, A, V, delimiter="\t"
    )
    (recording,) = by(
        tmp_path,
        write(tmp_path, text.encode("cp1250")),
        """encoding = "cp1250"
resample = true
fields = [{name = "Czas [ms]", role = "time", unit = "ms"},
  {name = "Prędkość [1/min]", role = "velocity", unit = "1/min"}]""",
    )
    assert recording.rate == pytest.approx(RATE, rel=1e-3)
    assert recording.channels[0].name == "Prędkość [1/min]"


RECIPES = {
    "springs_cd_disc_runs.csv": """rate = 100
fields = [
  {name = "Position (mm) Run #1", role = "displacement", unit = "mm", run = "1"},
  {name = "Position (mm) Run #2", role = "displacement", unit = "mm", run = "2"}]""",
    **dict.fromkeys(("arm_60.txt", "arm_80.txt", "arm_100.txt"), """even = true
fields = [{name = "Time_Elapsed(s)", role = "time", unit = "s"},
  {name = "Angle(deg)", role = "displacement", unit = "deg"}]"""),
    "pendulum_gap.txt": """parts = [{to = 79.229}]
fields = [{column = 1, role = "time", unit = "s"}, {column = 2, role = "x"}, {column = 3, role = "y"}]""",
    "torsion_drive_then_decay.txt": """fields = [{column = 1, role = "time", unit = "s"},
  {column = 3, role = "displacement", unit = "rad"}]""",
    "pendulum_lab1.txt": """fields = [{column = 1, role = "time", unit = "s"},
  {column = 2, role = "displacement", unit = "rad"}]""",
    "platform_heave.mat": "fields = [" + ",".join(
        f'{{name = "T_mean({k}).t_corrected", role = "time", unit = "s", run = "{k}"}}, '
        f'{{name = "T_mean({k}).y_norm", role = "displacement", unit = "counts", run = "{k}"}}' for k in range(1, 6)) + "]",
    "bicycle_fork.mat": 'fields = [{name = "data", role = "velocity", unit = "V"}]',
    "leg_test.mat": """fields = [{name = "data(:,1)", role = "time", unit = "s"},
  {name = "data(:,2)", role = "displacement", unit = "deg"}]""",
    "filmed_cable.csv": 'fields = [{name = "ts", role = "time"}, {name = "Theta0", role = "displacement", unit = "rad"}]',
    "coil_log.csv": """dialect = {header = false, commentRows = [1, 2]}
fields = [{column = 1, role = "time", unit = "us"}, {column = 2, role = "displacement", unit = "mV"}]""",
    "motor_unbalanced.csv": """encoding = "cp1250"
resample = true
fields = [{name = "Czas [ms]", role = "time", unit = "ms"},
  {name = "Przyspieszenie obudowy [m/s^2]", role = "acceleration", unit = "m/s^2", zero = "median"}]""",
}  # fmt: skip
FIELD_FILES = {
    "springs_cd_disc_runs.csv": (100.0, [3058, 2558]), "torsion_drive_then_decay.txt": (50.0, [3830]),
    "arm_60.txt": (259.42, [6560]), "arm_80.txt": (259.59, [7625]), "arm_100.txt": (259.53, [12278]),
    "pendulum_length_1.txt": (29.987, [4206]), "pendulum_length_3.txt": (29.987, [3948]),
    "pendulum_lab1.txt": (20.007, [2330]), "platform_heave.mat": (50.0, [201] * 5),
    "wheel_driven_cassy.txt": (9.9994, [6609]), "pendulum_lost_track.txt": (29.976, [2376]),
    "pendulum_gap.txt": (29.976, [2376]), "beam_steel.csv": (2048.0, [40960]), "bicycle_fork.mat": (1000.0, [30000]),
    "leg_test.mat": (100.0, [844]), "filmed_cable.csv": (30.0, [86]), "coil_log.csv": (2000.0, [7440]),
    "motor_unbalanced.csv": (147.02, [3225]),
}  # fmt: skip


@pytest.mark.skipif(
    not FIELD.is_dir(), reason="the recordings are not here (STATION_DATA names their folder)"
)
@pytest.mark.parametrize("name", FIELD_FILES)
def test_a_file_is_read_as_published_by_a_certain_guess_or_by_one_recipe(tmp_path: Path, name: str) -> None:
    rate, counts = FIELD_FILES[name]
    if name in RECIPES:
        with pytest.raises(Doubtful) as caught:
            look_at(FIELD / name).read()
        stated = {} if caught.value.settled else {"rate": rate}
        look_at(
            FIELD / name, recipe=caught.value.proposal.recipe.model_copy(update=stated)
        ).read()  # it is read, too
        recordings = by(tmp_path, FIELD / name, RECIPES[name])
    else:
        recordings = look_at(FIELD / name).read().recordings
    assert [recording.samples.shape[1] for recording in recordings] == counts
    known = 2.0 * recordings[0].rate_std if name.startswith("arm_") else 1e-4 * rate  # of stamps in bursts
    assert abs(recordings[0].rate - rate) < known < 2e-3 * rate
