"""`station import`: a session for each run and release; a refusal that says what to type."""

import json
import shlex

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
    written("goes_on.csv", "t (s),x (mm)", T, 9.0 * swing * np.clip(T / 4.0, 0.0, 1.0))
    answer = imported(capsys, "goes_on.csv")
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
    command = capsys.readouterr().err.split("Type: ")[1]
    words = shlex.split(" ".join(command.split()))
    assert words[:3] == ["station", "import", "ship 1.csv"]
    assert "displacement=phi" in words
    assert all(word in words for word in given)
    assert run([*words[1:], "--unit", "displacement=rad"]) == 0


def test_an_angle_from_two_columns_needs_both(capsys):
    phi = 0.5 * DECAY
    written("bob.csv", "t (s),x (m),y (m)", T, 3.0 + np.sin(phi), 1.0 - np.cos(phi))
    assert run(["import", "bob.csv", "--angle-from", "x"]) == 2
    assert "write two columns" in capsys.readouterr().err
    answer = imported(capsys, "bob.csv", "--angle-from", "x,y")
    np.testing.assert_allclose(Session.open(answer["sessions"][0]).recording().samples[0], phi, atol=1e-5)
