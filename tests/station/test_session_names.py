"""A session's name: in full, by a beginning that only one has, or `last`."""

from datetime import UTC, datetime, timedelta

import pytest

from daq.session_info import SessionInfo
from station import exits
from station.cli import run
from station.results.session_names import find_session, session_folder

BEGAN = datetime(2026, 1, 1, 12, tzinfo=UTC)


def stored(folder, *names):
    """Make sessions of these names, each a minute after the one before."""
    for number, name in enumerate(names):
        (folder / name).mkdir(parents=True)
        info = SessionInfo(name=name, created=BEGAN + timedelta(minutes=number))
        (folder / name / "session.json").write_text(info.model_dump_json(), encoding="utf-8")
    return folder


def test_any_beginning_that_only_one_session_has_is_its_name(tmp_path):
    sessions = stored(tmp_path, "mystery_7_20260101_120000", "release_20260101_120100")
    for beginning in ("mystery_7", "mystery_7_2026", "mys", "m"):
        assert find_session(beginning, sessions).name == "mystery_7_20260101_120000"


def test_a_name_in_full_wins_over_a_beginning(tmp_path):
    sessions = stored(tmp_path, "decay", "decay-2", "last", "later")
    assert find_session("decay", sessions).name == "decay"
    assert find_session("last", sessions).name == "last"


def test_mystery_7_is_not_mystery_70(tmp_path):
    sessions = stored(tmp_path, "mystery_7_20260101_120000", "mystery_70_20260101_120100")
    assert find_session("mystery_7", sessions).name == "mystery_7_20260101_120000"


def test_last_is_the_session_that_was_made_last(tmp_path):
    sessions = stored(tmp_path, "zebra", "alpha")
    assert find_session("last", sessions).name == "alpha"
    assert find_session("last", tmp_path / "none") is None


def test_a_folder_that_is_given_by_its_path_is_that_folder(tmp_path):
    sessions = stored(tmp_path / "sessions", "one")
    assert session_folder(str(sessions / "one"), tmp_path / "elsewhere") == sessions / "one"


@pytest.mark.parametrize("command", ["info", "identify", "compare", "verify", "recover", "replay", "refine"])
def test_an_ambiguous_beginning_is_one_sentence_with_five_candidates_and_code_2(
    command, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    stored(tmp_path / "sessions", *(f"decay_{number}" for number in range(7)))
    assert run([command, "decay"]) == exits.USAGE
    said = capsys.readouterr().err.strip()
    assert len(said.splitlines()) == 1
    assert "7 sessions begin so: decay_6, decay_5, decay_4, decay_3, decay_2 and 2 more" in said


@pytest.mark.parametrize("command", ["info", "verify", "recover"])
def test_a_name_that_nothing_begins_with_is_a_sentence_and_code_2(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    stored(tmp_path / "sessions", "decay")
    assert run([command, "nowhere"]) == exits.USAGE
    assert "nowhere: there is no such session" in capsys.readouterr().err
