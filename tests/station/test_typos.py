"""What is mistyped is answered at once, with what may have been meant, and by no library's own words."""

import socket

import pytest

from identify.effects.library import LIBRARY
from identify.effects.user import parse_effect
from mocks import cli as double
from station.cli import run
from station.exits import UsageProblem
from station.operations.new_session import session_info
from station.output import next_line
from station.settings import Settings, load_settings
from station.suggestions import did_you_mean

NAMES = [effect.name for effect in LIBRARY]


@pytest.mark.parametrize(
    ("typed", "meant"),
    [("stribek", "stribeck_friction"), ("cubic_stifness", "cubic_stiffness"), ("hystersis", "hysteresis")],
)
def test_a_mistyped_effect_gets_the_name_that_is_near(typed, meant):
    assert did_you_mean(typed, NAMES).startswith(f"; did you mean '{meant}'")


def test_a_word_that_is_near_nothing_gets_no_guess():
    assert did_you_mean("qqqqqqq", NAMES) == ""


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "sessions" / "release_one").mkdir(parents=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (["identify", "relese_one"], "did you mean 'release_one'"),
        (["verify", "sessions/relese_one"], "did you mean 'release_one'"),
        (["diagnos", "x"], "did you mean 'diagnose'"),
        (["refine", "release_one", "--add", "stribek"], "did you mean 'stribeck_friction'"),
        (["compare", "release_one", "--modl", "x"], "Did you mean '--model'"),
    ],
)
def test_a_typo_on_the_command_line_is_answered_before_anything_is_fitted(place, capsys, line, said):
    assert run(line) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("name", ["x", "velocity", "displacement", "xdot"])
def test_a_name_for_the_motion_in_an_own_effect_gets_its_letter(name):
    with pytest.raises(ValueError, match="displacement is u, velocity is v"):
        parse_effect(f"own = a*{name}")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mass": -3.0}, r"mass \[kg\] must be greater than 0 \(it is -3\)"),
        ({"operator": "x" * 300}, "at most 255 characters"),
    ],
)
def test_no_refusal_of_a_library_reaches_the_operator(options, said):
    given = {"mass": None, "mass_std": None, "specimen": None, "operator": None} | options
    with pytest.raises(UsageProblem, match=said) as refused:
        session_info(Settings(), **given)
    assert "validation" not in str(refused.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[specimen]\nmass_kg = -3", "specimen.mass_kg must be greater than 0"),
        ("[capture]\nrat = 3", "capture.rat is not known here; did you mean 'rate'"),
        ("[capture]\nrate = 'fast'", "capture.rate must be a number"),
    ],
)
def test_a_wrong_setting_is_told_in_words(tmp_path, text, said):
    (tmp_path / "station.toml").write_text(text)
    with pytest.raises(UsageProblem, match=said):
        load_settings(tmp_path / "station.toml")


def test_the_next_command_can_be_typed_where_a_name_has_blanks():
    assert next_line("compare", "my tests/one") == " next: station compare 'my tests/one'"


def test_the_double_refuses_a_port_that_is_taken_in_a_sentence(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken, pytest.raises(SystemExit) as left:
        double.main(["--tcp", str(taken.getsockname()[1])])
    assert left.value.code == 2
    assert "cannot be opened" in capsys.readouterr().err


@pytest.mark.parametrize("strength", ["1.5", "-0.1", "nan"])
def test_the_double_hides_no_more_than_the_whole(capsys, strength):
    with pytest.raises(SystemExit):
        double.main(["--tcp", "0", "--hide", f"hysteresis:{strength}"])
    assert "share of the total" in capsys.readouterr().err
