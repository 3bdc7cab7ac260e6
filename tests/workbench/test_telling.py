"""What the tabs of the page tell of a session: words, tables and pictures in the page's colours."""

import base64
import re
from dataclasses import replace
from pathlib import Path

import pytest

from daq.errors import SessionChanged
from daq.recording import Channel
from daq.session import Session
from station.operations.diagnosing import diagnose_sessions
from station.operations.examples import open_example
from station.operations.refining import add, open_refinement
from station.operations.session_set import open_sessions
from station.results.ladder import read_ladder, write_ladder
from station.results.sessions import open_session
from station.settings import Settings
from station.story.pipeline import silent
from station.suggestions import MEASURED_CURVE
from station.views.figure import inked
from station.views.identification_figures import record
from station.views.palette import DARK, LIGHT
from station.workbench import tasks, telling
from station.workbench.view_models import Drawn
from tests.workbench.test_page_parts import palette

DUFFING = Path(__file__).resolve().parent.parent / "data" / "hidden" / "release_14.csv"


pytestmark = pytest.mark.usefixtures("among_few")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return open_example("simulated_plain", tmp_path_factory.mktemp("told") / "sessions").folder


def drawing(part):
    return base64.b64decode(part.picture.uri.partition(",")[2]).decode()


def figures(told):
    return [part for part in told.brief if part.kind == "figure"]


def told_by(task, folder, *arguments):
    return task(Settings(sessions=folder.parent), silent, folder, *arguments)


def test_the_comparison_is_drawn_in_the_colours_of_the_page_every_axis_with_its_unit(folder):
    for dark, look in ((False, LIGHT), (True, DARK)):
        told = told_by(telling.compared, folder, dark)
        assert "times the noise" in told.headline
        plane, cycles = (drawing(part) for part in figures(told))
        for picture in (plane, cycles):
            assert {look.ink, look.paper} <= set(re.findall("#[0-9a-f]{6}", picture))
        for label in ("displacement [mm]", "velocity [m/s]", "frequency error [%]"):
            assert label in plane + cycles


@pytest.mark.parametrize(("scheme", "look"), [(":root", LIGHT), ("body.body--dark", DARK)])
def test_the_looks_of_the_page_are_the_colours_of_its_style_sheet(scheme, look):
    colours = palette(scheme)
    for name, colour in (
        ("ink", look.ink),
        ("paper", look.paper),
        ("model", look.model),
        ("left", look.second),
        *zip(("map-low", "map-middle", "map-high"), look.force, strict=True),
    ):
        assert [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)] == colours[name]


def test_a_record_without_analysis_is_shown_and_a_strangers_name_stays_text(folder):
    told = told_by(telling.recorded, folder, True)
    assert [len(figures(told)), told.headline] == [1, ""]
    recording = Session.open(folder).recording()
    evil = "<img src=x onerror=alert(1)>"[:24]
    named = replace(recording, channels=tuple(Channel(evil, "other", "V") for _ in recording.channels))
    with inked(LIGHT):
        picture = record(named).encoded("svg").decode()
    assert "&lt;img" in picture
    assert "<img" not in picture


def test_an_identification_is_told_with_both_methods_side_by_side(folder):
    told = told_by(telling.identified, folder, ())
    assert [part.kind for part in told.brief] == ["facts", "table", "facts"]
    assert told.headline.startswith(folder.name)


def test_a_worker_draws_the_suspects_that_another_one_found(tmp_path):
    settings = Settings(sessions=tmp_path / "sessions")
    folder = open_session(str(DUFFING), settings.sessions).folder
    told_by(tasks.look, folder)
    sessions = open_sessions((str(folder),), settings)
    found, document = diagnose_sessions(sessions)
    drawn = []
    tasks.complete(settings, drawn.append, folder, document.suspects)
    suspects = {name for one in drawn if isinstance(one, Drawn) for name in one.suspects}
    assert found.named == ("cubic_stiffness",)
    assert {"cubic_stiffness", MEASURED_CURVE} < suspects


def test_a_step_that_a_command_added_meanwhile_is_neither_hidden_by_a_diagnosis_nor_undone(tmp_path):
    settings = Settings(sessions=tmp_path / "sessions")
    session = open_session(str(DUFFING), settings.sessions)
    first = told_by(tasks.look, session.folder)

    def command(said):
        if len(read_ladder(session).steps) == 1:
            add(open_refinement(session, settings), "cubic_stiffness")

    write_ladder(session, first.ladder)
    seen = tasks.diagnose(settings, command, session.folder, ())
    assert seen.ladder.top.effects[-1] == "cubic_stiffness"
    with pytest.raises(SessionChanged):
        told_by(tasks.change, session.folder, tasks.restore, first.ladder)
    assert len(read_ladder(session).steps) == 2
