"""What a newcomer types wrong, and what each command ends with: read as the person at the terminal does."""

import numpy as np
import pytest

from identify.estimate import Estimate
from identify.formatting import SPACE, quantities, quantity, three_figures as figures, with_error
from station.cli import in_plain_words, run
from station.results.diagnosis_document import FindingDocument
from station.results.documents import EstimateDocument
from station.results.models import Value
from station.text.diagnosis_text import found_in_sensor


@pytest.mark.parametrize(
    ("library", "words"),
    [
        ("value: -3.0 is not in the range x>0", "value: it is -3.0, and must be above 0"),
        ("value: 99 is not in the range 0<=x<=50", "value: it is 99, and must be at least 0 and at most 50"),
        ("value: 1 is not in the range 1<x<2", "value: it is 1, and must be above 1 and below 2"),
        ("value: 'abc' is not a valid float range", "value: 'abc' is no number"),
        ("there is no command 'x'", "there is no command 'x'"),
    ],
)
def test_the_bounds_of_a_number_are_told_in_words(library, words):
    assert in_plain_words(library) == words


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (-1.18e6, 1e5, "(-1.18 ± 0.10) × 10⁶"),
        (-5.661e-7, 3e-7, "(-5.7 ± 3.0) × 10⁻⁷"),
        (959408.0, 3831.0, "(9.594 ± 0.038) × 10⁵"),
        (0.0, 7.3, "0.0 ± 7.3"),
        (1.0, 1e-13, "1.00000000000000 ± 0.00000000000010"),
        (2.5, 0.0, "2.5"),
        (2.5, float("nan"), "2.5 (error unknown)"),
    ],
)
def test_a_value_has_no_digit_that_its_error_does_not_bear(value, std, text):
    assert with_error(value, std).replace(SPACE, " ") == text


def test_no_figure_of_nine_digits_and_no_blank_for_a_unit_that_is_none():
    assert figures(123795784.0) == "1.24 × 10⁸"
    assert figures(99_000.0) == "99000"
    assert quantity(Estimate(0.002131, float("inf"), "")) == "0.002131 (error unknown)"
    assert quantity(Value(value=0.0, std=None, unit="N")).replace(SPACE, " ") == "0 N (error unknown)"


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "sessions" / "release_one").mkdir(parents=True)
    (tmp_path / "decay.csv").write_text("t,u\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["validate", "relese_one", "release_one"], "did you mean 'release_one'"),
        (["campaign", "sesions"], "did you mean 'sessions'"),
        (["recover", "relese_one"], "did you mean 'release_one'"),
        (["identify", "decy.csv"], "did you mean 'decay.csv'"),
        (["import", "decy.csv"], "did you mean 'decay.csv'"),
        (["import", "sessions"], "is a folder"),
        (["identify", "decay.csv", "--mass", "-3"], "must be above 0"),
        (["refine", "release_one", "--add"], "see `station refine --help`"),
        (["refine", "release_one", "--add", "qqqq"], "see `station effects`"),
        (["capture", "--rate", "-3"], "must be at least 5"),
    ],
)
def test_a_wrong_argument_is_answered_with_what_may_have_been_meant(place, capsys, line, said):
    assert run(line) == 2
    assert said in capsys.readouterr().err


def test_a_place_without_any_session_says_how_one_is_made(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["info", "last"]) == 2
    assert "there are none yet" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["doctor", "recover", "list"])
def test_a_command_without_a_session_ends_with_the_next_step(place, capsys, monkeypatch, command):
    monkeypatch.setattr("daq.ports.list_ports", lambda *_: ())
    assert run([command]) == 0
    out = capsys.readouterr().out
    assert "station " in out.splitlines()[-1]


def test_what_cannot_be_identified_is_to_be_looked_at(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    time = np.arange(400) / 100.0
    motion = 0.01 * np.exp(-1.5 * time) * np.cos(2 * np.pi * time)
    motion += 2e-4 * np.random.default_rng(1).standard_normal(len(time))
    np.savetxt(
        "few.csv", np.column_stack([time, motion]), delimiter=",", header="time_s,displacement_m", comments=""
    )
    assert run(["identify", "few.csv"]) == 8
    assert " next: station view " in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_table_ends_with_the_next_step_within_80_columns_and_as_latex_keeps_it_out(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert run(["demo", "--example", "simulated_stribeck"]) == 0
    capsys.readouterr()
    assert run(["table", "simulated_stribeck"]) == 0
    text = capsys.readouterr().out
    assert text.splitlines()[-1].startswith(" next: station compare")
    assert all(len(line) <= 80 for line in text.splitlines()[:-1])
    assert "* do not quote" in text  # something is hidden in it
    assert run(["table", "simulated_stribeck", "--format", "latex"]) == 0
    both = capsys.readouterr()
    assert "next:" not in both.out
    assert "next:" in both.err


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_a_campaign_ends_with_the_next_step(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["demo", "--example", "simulated_plain"]) == 0
    assert run(["campaign", "--workers", "1"]) == 0
    out = capsys.readouterr().out
    assert out.splitlines()[-1] == " next: station campaign --diagnose"
    assert "1 session identified" in out
    assert "by 1 worker " in out


def test_a_fault_is_told_by_its_own_words_where_it_has_some():
    found = FindingDocument(
        effect="channel_gain",
        title="the gains of the two channels disagree",
        channel=None,
        parameters={"error": EstimateDocument(value=0.01, std=0.03, unit="1")},
        what_to_do="calibrate both",
    )
    assert (
        found_in_sensor(found).replace(SPACE, " ")
        == "the gains of the two channels disagree (error = 0.010 ± 0.030)"
    )
    words = "the two sensors differ by 1.00 ± 0.02 %; a standard uncertainty of 3 % of their calibrations is assumed"
    assert found_in_sensor(found.model_copy(update={"words": words})) == words


def test_a_parameter_that_every_release_has_is_told_as_a_range():
    found = {f"fc[{i}]": Estimate(80.0 - i, 19.0, "Hz") for i in range(9)}
    told = quantities({"k3": Estimate(9000.0, 30.0, "1/s^2"), **found})
    assert [text.replace(SPACE, " ") for text in told] == [
        "k3 = 9000 ± 30 1/s^2",
        "fc = 72 to 80 Hz in 9 releases",
    ]
