"""The command line: it starts at once, says what is wrong in one sentence, and ends with the promised code."""

import json
import subprocess
import sys

import pytest

from station import exits
from station.cli import COMMANDS, run

HEAVY = ("numpy", "scipy", "numba", "rerun", "matplotlib", "pydantic", "serial", "rich", "daq", "identify")
"""What makes a start slow; how long it takes is measured by `python -m bench station`."""


def program(*arguments, cwd=None):
    return subprocess.run(
        [sys.executable, "-m", "station", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=120,
        check=False,
    )


def test_help_imports_nothing_heavy():
    code = f"import sys, station.cli; station.cli.run(['--help']); print([m for m in {HEAVY} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_help_names_every_command():
    text = program("--help").stdout
    assert all(f"  {name}" in text for name in COMMANDS)
    assert all(len(line) <= 80 for line in text.splitlines())


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_itself_within_80_columns(name, capsys):
    assert run([name, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"station {name}" in text
    assert all(len(line) <= 80 for line in text.splitlines())


@pytest.mark.parametrize(
    "arguments",
    [
        ["nonsense"],
        ["identify"],
        ["identify", "--max-order", "9", "x"],
        ["import", "a", "--rate", "-1"],
        ["--nonsense"],
    ],
    ids=" ".join,
)
def test_a_wrong_command_line_ends_with_2_and_says_where_to_look(arguments, capsys):
    assert run(arguments) == exits.USAGE
    out, err = capsys.readouterr()
    assert out == ""
    assert "Traceback" not in err
    assert "--help" in err
    assert len(err.strip().splitlines()) == 1


def test_a_session_that_is_not_there_is_a_sentence_and_code_2(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["identify", "nowhere"]) == exits.USAGE
    assert "nowhere" in capsys.readouterr().err


def test_with_json_an_error_is_one_object_on_stdout(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["identify", "nowhere", "--json"]) == exits.USAGE
    out, err = capsys.readouterr()
    error = json.loads(out)["error"]
    assert error["exit_code"] == exits.USAGE
    assert "nowhere" in error["message"]
    assert "nowhere" in err


def test_an_interruption_ends_with_130(monkeypatch, capsys):
    import station.text.layout as module

    def interrupted(*_arguments, **_options):
        interrupt = KeyboardInterrupt()
        interrupt.session = "where it lies"  # as a capture says
        raise interrupt

    monkeypatch.setattr(module, "print_json", interrupted)
    assert run(["list", "--json"]) == exits.INTERRUPTED
    assert "interrupted; what was received is kept in where it lies" in capsys.readouterr().err


def test_a_fault_of_the_program_ends_with_1_in_a_sentence(monkeypatch, capsys):
    import station.text.layout as module

    def broken(*_arguments, **_options):
        raise ZeroDivisionError("a made-up fault")

    monkeypatch.setattr(module, "print_json", broken)
    assert run(["list", "--json"]) == exits.UNEXPECTED
    err = capsys.readouterr().err
    assert "a made-up fault" in err
    assert "Traceback" not in err
    assert run(["--debug", "list", "--json"]) == exits.UNEXPECTED
    assert "Traceback" in capsys.readouterr().err


def test_errors_have_the_code_of_whose_fault_they_are():
    from daq import errors
    from identify.errors import NotIdentifiable

    assert exits.code_of(errors.PortError("none")) == exits.NO_BOARD
    assert exits.code_of(errors.PortBusy("busy")) == exits.NO_BOARD
    assert exits.code_of(errors.BoardError("2.0")) == exits.PROTOCOL
    assert exits.code_of(errors.DataLost("lost")) == exits.LOST_DATA
    assert exits.code_of(errors.LinkLost("silent")) == exits.DISCONNECTED
    assert exits.code_of(errors.StorageError("full")) == exits.STORAGE
    assert exits.code_of(OSError("full")) == exits.STORAGE
    assert exits.code_of(errors.SessionChanged("changed")) == exits.CONFLICT
    assert exits.code_of(errors.SessionLocked("locked")) == exits.CONFLICT
    assert exits.code_of(NotIdentifiable("too short")) == exits.NOT_IDENTIFIABLE
    assert exits.code_of(errors.OperatorError("waited")) == exits.USAGE
    assert exits.code_of(ValueError("?")) == exits.UNEXPECTED


def test_settings_that_are_wrong_are_told_with_their_entry(tmp_path, capsys):
    file = tmp_path / "station.toml"
    file.write_text("[specimen]\nmass_kg = -3\n")
    assert run(["--settings", str(file), "list"]) == exits.USAGE
    err = capsys.readouterr().err
    assert "specimen.mass_kg" in err
    file.write_text("[specimen\n")
    assert run(["--settings", str(file), "list"]) == exits.USAGE
    assert "TOML" in capsys.readouterr().err
    file.write_text("[specimen]\nmasse = 3\n")
    assert run(["--settings", str(file), "list"]) == exits.USAGE
    assert "specimen.masse" in capsys.readouterr().err
