"""A campaign from a folder to its tables: resumed, changed, interrupted; failures are lines; trends are those put in."""

import csv
import io
import json

import pytest
from many_sessions import SOFTER_PER_DEGREE, STIFFNESS, Here, make_noise, make_sessions

from daq.session import Session
from station.campaign.metadata import Known
from station.campaign.run import run_campaign
from station.campaign.sources import find_sources
from station.campaign.together import campaign_document
from station.cli import run as station
from station.results.campaign_document import CampaignDocument
from station.settings import Settings
from station.text.campaign_text import duration, sessions_csv, trends_csv

COUNT = 8


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Eight sessions, one of noise and one that is damaged; and what a campaign says of them."""
    folder = make_sessions(tmp_path_factory.mktemp("many") / "sessions", COUNT)
    make_noise(folder / "still")
    (folder / "torn").mkdir()
    (folder / "torn" / "session.json").write_text("{")
    run, crew = campaign(folder)
    return folder, run, crew, campaign_document(folder / "campaign", False, run)


def campaign(folder, crew=None, *, diagnose=False, settings=None):
    crew = crew or Here()
    settings = settings or Settings()
    sources = find_sources((str(folder),), settings)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("station.campaign.run.performed", crew)
        return run_campaign(sources, settings, folder / "campaign", 1, diagnose=diagnose), crew


def test_every_session_has_its_row_and_a_failed_one_its_reason(made):
    _, _, crew, document = made
    assert len(crew.performed_names) == COUNT + 1  # the damaged one is not handed to anybody
    assert [row.result.session for row in document.rows] == [f"r{i:03d}" for i in range(COUNT)]
    assert [one.session for one in document.failed] == ["still", "torn"]
    assert all(one.reason for one in document.failed)
    k = [row.result.parameters["linear_stiffness.k"] for row in document.rows]
    for found, row in zip(k, document.rows, strict=True):
        softer = SOFTER_PER_DEGREE * (row.conditions["temperature [degC]"] - 20.0)
        assert found.value == pytest.approx(STIFFNESS * (1.0 + softer), abs=6 * found.std)


def test_the_trend_that_was_put_in_is_found_with_its_unit_and_the_first_of_all(made):
    trends = {(t.parameter, t.against): t for t in made[3].trends}
    found = trends["linear_stiffness.k", "temperature"]
    assert found.sure
    assert found.unit == "1/s^2 per degC"
    assert found.slope == pytest.approx(STIFFNESS * SOFTER_PER_DEGREE, abs=5 * found.std)
    assert not trends["coulomb_friction.mu_0", "temperature"].sure
    assert ("linear_stiffness.k", "date") in trends
    assert [t.p_value for t in made[3].trends] == sorted(t.p_value for t in made[3].trends)


def test_a_second_run_does_nothing_and_says_the_same(made):
    folder, _, _, first = made
    again, crew = campaign(folder)
    assert crew.performed_names == []
    assert again.kept == COUNT + 1
    document = campaign_document(folder / "campaign", False, again)
    assert document.rows == first.rows
    assert document.trends == first.trends
    assert document.failed == first.failed


def test_only_what_is_missing_changed_or_unreadable_is_done_again(made, tmp_path):
    folder = make_sessions(tmp_path / "sessions", 4)
    campaign(folder)
    Session.open(folder / "r000").update(mass_kg=2.0)  # another result
    Session.open(folder / "r001").update(remarks="a draught", conditions={"temperature [degC]": 30.0})
    next((folder / "campaign" / "sessions").glob("r002-*")).write_text("{")
    run, crew = campaign(folder)
    assert crew.performed_names == ["r000", "r002"]
    document = campaign_document(folder / "campaign", False, run)
    assert document.rows[1].conditions["temperature [degC]"] == 30.0  # read afresh
    assert document.rows[0].result.parameters["wavelet.K"].unit == "N/m"


def test_an_interrupted_run_keeps_what_is_done_and_the_next_goes_on(tmp_path):
    folder = make_sessions(tmp_path / "sessions", 4)
    with pytest.raises(KeyboardInterrupt):
        campaign(folder, Here(after=2))
    run, crew = campaign(folder)
    assert (run.kept, crew.performed_names) == (2, ["r002", "r003"])


def test_the_operators_numbers_and_dates_come_before_the_sessions(made):
    folder, run, _, _ = made
    known = {"r003": Known(None, {"temperature [degC]": -5.0, "humidity [%]": 40.0})}
    rows = campaign_document(folder, False, run, known).rows
    assert rows[3].conditions["humidity [%]"] == 40.0
    assert rows[3].conditions["temperature [degC]"] == -5.0
    assert rows[4].conditions["temperature [degC]"] != -5.0


def test_the_document_is_read_back_as_it_was_written(made):
    document = made[3]
    assert CampaignDocument.model_validate_json(document.model_dump_json()) == document


def test_the_tables_hold_every_parameter_with_its_error_and_no_formula(made):
    document = made[3].model_copy(
        update={"failed": [made[3].failed[0].model_copy(update={"session": "=SUM(A1)"})]}
    )
    rows = list(csv.DictReader(io.StringIO(sessions_csv(document))))
    assert len(rows) == COUNT + 1
    first = made[3].rows[0].result
    assert float(rows[0]["linear_stiffness.k [1/s^2]"]) == first.parameters["linear_stiffness.k"].value
    assert float(rows[0]["linear_stiffness.k std [1/s^2]"]) == first.parameters["linear_stiffness.k"].std
    assert float(rows[0]["motion_percent"]) == first.motion_percent
    assert rows[-1]["session"] == "'=SUM(A1)"
    assert rows[-1]["failed"] == made[3].failed[0].reason
    trends = list(csv.DictReader(io.StringIO(trends_csv(document))))
    assert len(trends) == len(document.trends)
    assert float(trends[0]["slope"]) == document.trends[0].slope


@pytest.fixture
def at_home(monkeypatch):
    """Let the command work in this process."""
    monkeypatch.setattr("station.campaign.run.performed", Here())


def test_the_command_prints_one_screen_and_keeps_its_tables(made, at_home, capsys):
    folder = made[0]
    assert station(["campaign", str(folder)]) == 0
    printed = capsys.readouterr()
    *page, following = printed.out.splitlines()
    assert max(len(line) for line in page) <= 80
    assert following.startswith(" next: station ")
    assert "8 sessions identified, 2 failed" in printed.out
    assert "linear_stiffness.k against" in printed.out
    assert "1/s² per" in printed.out
    assert "failed: torn: " in printed.err
    assert "all was kept from before" in printed.out
    kept = {file.name for file in (folder / "campaign").iterdir()}
    assert kept == {"campaign.json", "sessions.csv", "trends.csv", "sessions"}


def test_json_is_the_document_that_is_kept(made, at_home, capsys, tmp_path):
    table = tmp_path / "known.csv"
    table.write_text("session;date;humidity [%];who\nr000;2026-01-02;41,5;Ada\nr009;;40;\n", encoding="utf-8")
    assert station(["campaign", str(made[0]), "--metadata", str(table), "--json"]) == 0
    printed = capsys.readouterr()
    document = json.loads(printed.out)
    assert document["rows"][0]["conditions"]["humidity [%]"] == 41.5
    assert document["rows"][0]["made"].startswith("2026-01-02")
    assert "who holds text" in printed.err
    assert "1 of the 2 sessions" in printed.err
    kept = CampaignDocument.model_validate_json((made[0] / "campaign" / "campaign.json").read_bytes())
    assert kept.plain() == document


def test_sessions_without_any_result_end_with_the_code_that_says_so(at_home, tmp_path, capsys):
    make_noise(tmp_path / "sessions" / "still")
    assert station(["campaign", str(tmp_path / "sessions"), "--output", str(tmp_path / "out")]) == 8
    assert "none of the 1 sessions has a result" in capsys.readouterr().err
    assert not (tmp_path / "sessions" / "campaign").exists()
    assert station(["campaign", str(tmp_path / "sessions"), "--json"]) == 8
    assert [one["session"] for one in json.loads(capsys.readouterr().out)["failed"]] == ["still"]


def test_a_session_that_is_still_written_is_left_alone(tmp_path):
    session = make_noise(tmp_path / "sessions" / "now")
    session.update(state="recording")
    run, crew = campaign(tmp_path / "sessions")
    assert crew.performed_names == []
    assert "station recover" in run.failed[0].reason


def test_ctrl_c_says_that_the_same_command_goes_on(tmp_path, monkeypatch, capsys):
    make_noise(tmp_path / "sessions" / "still")
    monkeypatch.setattr("station.campaign.run.performed", Here(after=0))
    assert station(["campaign", str(tmp_path / "sessions")]) == 130
    assert "the same command continues with the rest" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["empty"], "no session in empty"),
        (["nowhere"], "there is no such folder, session or data file"),
        (["empty", "--metadata", "no.csv"], "cannot be read"),
    ],
)
def test_wrong_usage_is_a_sentence(words, sentence, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "empty").mkdir()
    make_noise(tmp_path / "still")
    assert station(["campaign", *words]) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.slow
def test_a_diagnosed_session_has_its_verdict_and_the_named_effects_parameters(tmp_path):
    from hidden import DUFFING

    from station.results.sessions import open_session

    open_session(str(DUFFING), tmp_path / "sessions")
    run, _ = campaign(tmp_path / "sessions", diagnose=True)
    (row,) = campaign_document(tmp_path, True, run).rows
    assert (row.result.verdict, row.result.named) == ("missing_effect", ["cubic_stiffness"])
    assert row.result.parameters["cubic_stiffness.k3"].std > 0
    assert row.result.motion_percent_named < 0.5 * row.result.motion_percent
    identified, crew = campaign(tmp_path / "sessions")  # without the diagnosis: another result, also kept
    assert len(crew.performed_names) == 1
    assert identified.results[0][1].verdict is None


@pytest.mark.parametrize(
    ("seconds", "text"), [(46.2, "46 s"), (720, "12 min"), (12240, "3.4 h"), (0.2, "0 s")]
)
def test_a_time_is_said_as_people_do(seconds, text):
    assert duration(seconds) == text
