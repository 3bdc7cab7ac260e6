"""`station import`: a session for each run and release; a refusal that says what to type."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from daq.session import Session
from station.cli import run

RATE = 100.0
N = 1200
T = np.arange(N) / RATE
DECAY = np.exp(-0.2 * T) * np.cos(2 * np.pi * 1.3 * T)


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def written(name, header, *columns):
    rows = (",".join(f"{v:.9g}" for v in row) for row in zip(*columns, strict=True))
    with open(name, "w", encoding="utf-8") as file:
        file.write("\n".join([header, *rows]) + "\n")


def imported(capsys, *arguments):
    assert run(["import", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_each_run_of_a_wide_file_becomes_a_session_with_its_number(capsys):
    written("wide.csv", "t1 (s),x1 (mm),t2 (s),x2 (mm)", T, 20 * DECAY, T, 10 * DECAY)
    answer = imported(capsys, "wide.csv")
    assert [s.rsplit("/", 1)[-1] for s in answer["sessions"]] == ["wide_run1", "wide_run2"]
    assert answer["runs"] == ["1", "2"]
    second = Session.open(answer["sessions"][1]).recording()
    np.testing.assert_allclose(second.samples[0], 0.01 * DECAY, atol=1e-8)
    again = imported(capsys, "wide.csv", "--run", "2")
    assert [s.rsplit("/", 1)[-1] for s in again["sessions"]] == ["wide"]


def test_what_is_printed_of_many_runs_is_short(capsys):
    header = ",".join(f"t{i} (s),x{i} (mm)" for i in range(1, 13))
    written("wide.csv", header, *(c for i in range(12) for c in (T, (20 - i) * DECAY)))
    assert run(["import", "wide.csv"]) == 0
    out = capsys.readouterr().out
    assert "12 runs in the file" in out
    assert len(out.splitlines()) < 45


def test_a_push_before_the_decay_is_left_out_unless_the_part_is_chosen(capsys):
    # sixteen strokes of the hand, in time with the motion, each larger than the last; then nothing touches it
    pushed = (
        np.clip(T / 3.0, 0.0, 1.0) * np.exp(-0.4 * np.clip(T - 3.0, 0.0, None)) * np.sin(2 * np.pi * 1.3 * T)
    )
    written("pushed.csv", "t (s),a (m/s^2)", T, 5.0 * pushed)
    answer = imported(capsys, "pushed.csv")
    left = Session.open(answer["sessions"][0]).recording().samples.shape[1]
    assert 3.0 - 0.8 < (N - left) / RATE < 3.0 + 0.8
    assert any("a push was found before the decay" in note for note in answer["notes"])
    kept = imported(capsys, "pushed.csv", "--from", "0")
    assert Session.open(kept["sessions"][0]).recording().samples.shape[1] == N
    part = imported(capsys, "pushed.csv", "--from", "4", "--to", "9.99")
    assert Session.open(part["sessions"][0]).recording().samples.shape[1] == 600


def test_a_drive_that_stops_is_left_out_and_one_that_goes_on_is_kept(capsys):
    swing = np.sin(2 * np.pi * 1.3 * T)
    written("stops.csv", "t (s),x (mm)", T, 9.0 * swing * np.exp(-0.5 * np.clip(T - 5.0, 0.0, None)))
    answer = imported(capsys, "stops.csv")
    left = Session.open(answer["sessions"][0]).recording().samples.shape[1]
    assert 5.0 - 0.4 < (N - left) / RATE < 5.0 + 1.0
    beating = np.exp(-0.1 * T) * swing + 0.6 * np.sin(2 * np.pi * 1.7 * T)
    for name, driven in (("goes_on.csv", swing * np.clip(T / 4.0, 0.0, 1.0)), ("beats.csv", beating)):
        written(name, "t (s),x (mm)", T, 9.0 * driven)
        answer = imported(capsys, name)
        assert Session.open(answer["sessions"][0]).recording().samples.shape[1] == N


@pytest.mark.parametrize("loss", [0.02, 0.3])
@pytest.mark.parametrize("law", ["viscous", "dry", "quadratic"])
def test_a_decay_from_the_first_sample_is_kept_whole_whatever_its_damping(capsys, loss, law):
    envelope = {
        "viscous": np.exp(-loss * T),
        "dry": np.clip(1.0 - 0.5 * loss * T, 0.0, None),
        "quadratic": 1.0 / (1.0 + loss * T),
    }[law]
    written("decay.csv", "t (s),x (mm)", T, 9.0 * envelope * np.cos(2 * np.pi * 1.3 * T))
    answer = imported(capsys, "decay.csv")
    assert Session.open(answer["sessions"][0]).recording().samples.shape[1] == N


@pytest.mark.parametrize("given", [[], ["--unit", "displacement=mm"], ["--keep-derived", "--to", "9"]])
def test_the_command_in_a_refusal_works_when_it_is_typed(capsys, given):
    written("ship 1.csv", "time,x,y,phi,theta", T, T, 0.1 * T**2, 0.1 * DECAY, 0.001 * T)
    assert run(["import", "ship 1.csv", *given]) == 2
    told = capsys.readouterr()
    assert 'role = "displacement"' in told.out  # the recipe that would be used
    command = told.err.split("type: ")[1]
    words = shlex.split(" ".join(command.split()))
    assert words[:3] == ["station", "import", "ship 1.csv"]
    assert all(word in words for word in given)
    assert run(words[1:]) == 0


def test_what_a_refusal_suggests_is_what_a_shell_takes(capsys):
    written("odd.csv", "t (s),data(:;2)", T, DECAY)
    assert run(["import", "odd.csv"]) == 2
    words = shlex.split(capsys.readouterr().err.split("as in ")[1].split(". These")[0], posix=True)
    assert run(["import", "odd.csv", *words]) == 0


def test_stamps_that_were_put_on_an_even_clock_are_not_to_be_put_there(capsys):
    strays = T + 0.004 * np.sin(np.arange(N) ** 2.0)
    written("strays.csv", "t (s),x (mm)", strays, 9.0 * np.interp(strays, T, DECAY))
    assert run(["import", "strays.csv"]) == 2
    assert "with --resample" in capsys.readouterr().err
    notes = " ".join(imported(capsys, "strays.csv", "--accept")["notes"])
    assert notes.count("the time stamps stray") == 1
    assert "--resample" not in notes


def test_an_angle_from_two_columns_needs_both(capsys):
    phi = 0.5 * DECAY
    written("bob.csv", "t (s),x (m),y (m)", T, 3.0 + np.sin(phi), 1.0 - np.cos(phi))
    assert run(["import", "bob.csv", "--angle-from", "x"]) == 2
    assert "write two columns" in capsys.readouterr().err
    answer = imported(capsys, "bob.csv", "--angle-from", "x,y")
    np.testing.assert_allclose(Session.open(answer["sessions"][0]).recording().samples[0], phi, atol=1e-5)


SPRINGS = "Position (mm) Run #1;Position (mm) Run #2\n" + "".join(
    f"{a:.4f};{b:.4f}\n".replace(".", ",") for a, b in zip(60 + 9 * DECAY, 33 + 5 * DECAY, strict=True)
)


def test_an_answer_is_given_once_and_found_again_for_the_next_file_of_that_shape(capsys):
    for name in ("first.csv", "second.csv"):
        with open(name, "w", encoding="utf-8") as file:
            file.write(SPRINGS)
    assert run(["import", "first.csv"]) == 2
    told = capsys.readouterr()
    assert "names no rate" in told.err
    assert "--accept --rate HZ" in told.err
    assert "rate" not in told.out
    assert run(["import", "first.csv", "--accept"]) == 2  # a rate that nobody stated is taken by nobody
    assert "give the rate in Hz with --rate" in capsys.readouterr().err
    answer = imported(capsys, "first.csv", "--rate", "100")
    assert answer["runs"] == ["1", "2"]
    again = imported(capsys, "second.csv")
    assert (again["rate_hz"], again["runs"]) == (RATE, ["1", "2"])
    assert "confirmed for first_run2" in again["notes"][0]
    assert run(["import", "second.csv", "--recipe", "none"]) == 2


def test_rows_that_are_said_to_be_even_are_read_at_the_rate_of_each_file_s_own_stamps(capsys):
    steps = np.random.default_rng(5).uniform(0.02, 0.1, N // 5)
    for name, scale in (("first.csv", 1.0), ("second.csv", 3.0)):
        written(name, "t (s),x (mm)", scale * np.repeat(np.cumsum(steps), 5), 9.0 * DECAY)
    answer = imported(capsys, "first.csv", "--accept")
    assert "the rows are said to be even" in " ".join(answer["notes"])
    again = imported(capsys, "first.csv", "--recipe", f"{answer['sessions'][0]}/recipe.toml")
    assert again["rate_hz"] == answer["rate_hz"]
    assert imported(capsys, "second.csv")["rate_hz"] == pytest.approx(answer["rate_hz"] / 3.0)


def test_of_a_file_of_one_recording_no_run_is_to_be_named(capsys):
    written("one.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    assert run(["import", "one.csv", "--run", "2"]) == 2
    assert "has no run '2'; it holds one recording: leave --run out" in capsys.readouterr().err


def test_a_delimiter_of_two_characters_gets_a_sentence(capsys):
    written("one.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    assert run(["import", "one.csv", "--delimiter", "ab"]) == 2
    assert "the delimiter must be one character, 'tab' or 'blank', not 'ab'" in capsys.readouterr().err


def test_after_an_import_without_a_release_info_proposes_nothing_that_refuses(capsys):
    written("noise.csv", "t (s),x (mm)", T, np.random.default_rng(3).standard_normal(N))
    written("decay.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    for name, proposed in (("noise", False), ("decay", True)):
        assert run(["import", f"{name}.csv"]) == 0
        capsys.readouterr()
        assert run(["info", name]) == 0
        assert ("next: station identify" in capsys.readouterr().out) is proposed


@pytest.mark.parametrize("folder", ["", "."])
def test_a_session_without_a_name_gets_a_sentence(capsys, folder):
    written("decay.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    assert run(["import", "decay.csv", "--session", folder]) == 2
    assert "--session names no folder" in capsys.readouterr().err


def test_bare_numbers_are_runs_once_somebody_says_so(capsys):
    for name in ("two.csv", "next.csv"):
        written(name, "t (s),x1 (mm),x2 (mm)", T, 9.0 * DECAY, 5.0 * DECAY)
    assert run(["import", "two.csv"]) == 2
    assert "if they are releases of one rig, --run all" in capsys.readouterr().err
    assert imported(capsys, "two.csv", "--run", "all")["runs"] == ["1", "2"]
    assert imported(capsys, "next.csv")["runs"] == ["1", "2"]


def test_two_loggers_with_equal_names_and_other_units_are_not_confused(capsys):
    imported_first = ("--column", "displacement=b", "--unit", "displacement=0.5 mm")
    written("first.csv", "a,b\n(s),(mm)", T, 20 * DECAY)
    imported(capsys, "first.csv", *imported_first)
    written("alike.csv", "a,b\n(s),(mm)", T, 19 * DECAY)
    assert "confirmed for first" in imported(capsys, "alike.csv")["notes"][0]
    written("other.csv", "a,b\n(s),(m)", T, 0.02 * DECAY)
    answer = imported(capsys, "other.csv")
    assert "confirmed" not in answer["notes"][0]
    assert np.max(Session.open(answer["sessions"][0]).recording().samples) == pytest.approx(0.02)


def test_what_is_accepted_or_asked_of_a_file_without_names_is_the_kept_recipe_that_was_shown(
    capsys, monkeypatch
):
    motor = np.sin(2 * np.pi * 0.9 * T)
    for name in ("motor_0.900", "motor_0.968"):
        written(name, "", T, motor, DECAY)
    chosen = ("--column", "displacement=3", "--unit", "displacement=counts", "--unit", "time=s")
    assert imported(capsys, "motor_0.900", *chosen)["sessions"] == ["sessions/motor_0.900"]
    assert run(["import", "motor_0.968"]) == 2
    assert "confirmed for motor_0.900" in capsys.readouterr().err
    opened = []
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    monkeypatch.setattr("click.edit", lambda filename: opened.append(Path(filename).read_text()))
    imported(capsys, "motor_0.968", "--ask", "--session", "asked")
    assert '{column = 3, role = "displacement", unit = "counts"}' in opened[0]
    answer = imported(capsys, "motor_0.968", "--accept")
    assert "read by the recipe that was confirmed for" in answer["notes"][0]
    np.testing.assert_allclose(Session.open(answer["sessions"][0]).recording().samples[0], DECAY, atol=1e-8)


def test_a_kept_recipe_that_cannot_read_a_file_is_not_proposed_for_it(capsys):
    written("circuit.txt", "", 1e3 * T, 500.0 * DECAY)
    imported(capsys, "circuit.txt", "--column", "displacement=2", "--unit", "time=us")
    written("frame.txt", "", T, DECAY)
    assert run(["import", "frame.txt"]) == 2
    told = capsys.readouterr()
    assert "nothing says whether column 2 is a displacement" in told.err
    assert 'role = "time", unit = "s"' in told.out


def test_json_of_a_refused_file_holds_the_proposed_recipe(capsys):
    written("odd.csv", "", T, DECAY)
    assert run(["import", "odd.csv", "--json"]) == 2
    answer = json.loads(capsys.readouterr().out)["error"]
    assert answer["doubts"]
    Path("proposed.toml").write_text(answer["recipe"], encoding="utf-8")
    assert imported(capsys, "odd.csv", "--recipe", "proposed.toml")["rate_hz"] == pytest.approx(RATE)


def test_a_recipe_is_kept_can_be_corrected_and_says_all(capsys):
    written("one.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    kept = Session.open(imported(capsys, "one.csv")["sessions"][0]).folder / "recipe.toml"
    recipe = kept.read_text(encoding="utf-8")
    with open("mine.toml", "w", encoding="utf-8") as file:
        file.write(recipe.replace('unit = "mm"', 'unit = "0.5 mm", sign = -1, zero = 2.0'))
    answer = imported(capsys, "one.csv", "--recipe", "mine.toml")
    mine = Session.open(answer["sessions"][0])
    np.testing.assert_allclose(mine.recording().samples[0], -0.0005 * (9.0 * DECAY - 2.0), atol=1e-9)
    assert run(["verify", str(mine.folder)]) == 0
    capsys.readouterr()
    assert run(["import", "one.csv", "--recipe", "mine.toml", "--rate", "50"]) == 2
    assert "says how the whole file is read" in capsys.readouterr().err


def test_the_parts_of_a_recipe_are_sessions_and_not_cut_further(capsys):
    again = np.concatenate([DECAY, DECAY])
    written("two.csv", "t (s),x (mm)", np.arange(2 * N) / RATE, 9.0 * again)
    assert len(imported(capsys, "two.csv")["sessions"]) == 2
    with open("mine.toml", "w", encoding="utf-8") as file:
        file.write(
            'fields = [{name = "t (s)", role = "time"}, {name = "x (mm)", role = "displacement", unit = "mm"}]\n'
        )
        file.write("parts = [{}]\n")
    assert len(imported(capsys, "two.csv", "--recipe", "mine.toml")["sessions"]) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("recipe = 2", "recipe: Input should be 1"),
        ("recipe = 1\nrat = 3", "rat: Extra inputs are not permitted"),
        ('fields = [{name = "t", role = "time", unit = "mm"}]', "fields.1: 'mm' is no unit of time"),
        ("fields = [{", "is no recipe in TOML"),
        ('fields = [{name = "u", role = "displacement"}]', "the recipe's displacement is in column 'u'"),
    ],
)
def test_a_recipe_that_is_none_gets_a_sentence(capsys, text, said):
    written("one.csv", "t (s),x (mm)", T, 9.0 * DECAY)
    with open("mine.toml", "w", encoding="utf-8") as file:
        file.write(text)
    assert run(["import", "one.csv", "--recipe", "mine.toml"]) == 2
    assert said in capsys.readouterr().err


def test_asking_opens_the_recipe_until_the_file_can_be_read_by_it(capsys, monkeypatch):
    written("odd.csv", "clock,alpha_raw,beta", T, 9.0 * DECAY, np.cos(T))
    seen = []

    def edit(filename):
        place = Path(filename)
        text = place.read_text(encoding="utf-8")
        seen.append(text)
        fields = '{name = "clock", role = "time"}, {name = "alpha_raw", role = "displacement", unit = "UNIT"}'
        unit = "mm/s" if len(seen) == 1 else "deg"
        head = "".join(line for line in text.splitlines(True) if line.startswith("#"))
        place.write_text(f"{head}recipe = 1\nfields = [{fields.replace('UNIT', unit)}]\n", encoding="utf-8")

    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("click.edit", edit)
    assert run(["import", "odd.csv", "--ask"]) == 0
    assert "#   2 alpha_raw: 9, " in seen[0]
    assert "'mm/s' is no unit of displacement" in seen[1]
    recording = Session.open("sessions/odd").recording()
    np.testing.assert_allclose(recording.samples[0], np.radians(9.0 * DECAY), atol=1e-9)


def test_a_recipe_that_is_emptied_imports_nothing(capsys, monkeypatch):
    written("odd.csv", "clock,alpha_raw,beta", T, 9.0 * DECAY, np.cos(T))
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("click.edit", lambda filename: Path(filename).write_text(""))
    assert run(["import", "odd.csv", "--ask"]) == 2
    assert "nothing was imported" in capsys.readouterr().err


def test_asking_needs_a_terminal(capsys):
    written("odd.csv", "clock,alpha_raw,beta", T, 9.0 * DECAY, np.cos(T))
    assert run(["import", "odd.csv", "--ask"]) == 2
    assert "needs a terminal" in capsys.readouterr().err


def test_a_recording_that_is_not_sound_says_so_as_it_is_imported(capsys):
    held = 20.0 * DECAY[np.arange(N) // 7 * 7]
    written("held.csv", "t (s),x (mm)", T, held)
    written("sound.csv", "t (s),x (mm)", T, 20.0 * DECAY)
    assert run(["import", "held.csv"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "verdict REJECT; x (mm) repeats the reading before it" in out
    assert run(["import", "sound.csv"]) == 0
    assert "verdict" not in capsys.readouterr().out
    assert imported(capsys, "held.csv")["verdicts"] == ["REJECT"]


@pytest.mark.parametrize("held", [True, False])
def test_a_spline_through_uneven_stamps_hides_no_reading_that_was_repeated(capsys, held):
    random = np.random.default_rng(3)
    stamps = T + random.uniform(-0.4, 0.4, N) / RATE
    there = 20.0 * np.exp(-0.2 * stamps) * np.cos(2 * np.pi * 1.3 * stamps)
    again = np.flatnonzero(random.random(N - 1) < 0.1) + 1
    if held:
        there[again] = there[again - 1]
    written("uneven.csv", "t (s),x (mm)", stamps, there)
    told = " ".join(imported(capsys, "uneven.csv", "--resample")["notes"])
    assert "cubic spline" in told
    assert ("before the spline: x (mm) repeats the reading before it" in told) == held
