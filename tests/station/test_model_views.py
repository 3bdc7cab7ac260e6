"""The Ladder tab, read back: what it shows is what was found, and every step has a tab."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
import rerun as rr
from hidden import DUFFING, TRUTH
from rerun.chunk import RrdReader

from daq.session import Session
from identify.residual import times
from station.operations import viewer_tabs
from station.operations.identifying import identify_session
from station.operations.refining import add, open_refinement, step_again
from station.operations.session_set import open_sessions
from station.settings import Settings
from station.views import tabs, viewer
from station.views.palette import VIEWERS


@pytest.fixture(scope="module")
def refinement(tmp_path_factory, diagnosed):
    settings = Settings(sessions=tmp_path_factory.mktemp("sessions"))
    session = Session.open(shutil.copytree(diagnosed, settings.sessions / DUFFING.stem))
    begun = open_refinement(session, settings)
    return replace(begun, ladder=add(begun, "cubic_stiffness"))


@pytest.fixture(scope="module")
def file(refinement):
    result, _ = identify_session(refinement.session, Settings())
    return viewer_tabs.write_view(refinement.session, result, Settings(), refinement)


def chunks(file, path):
    return [chunk.to_record_batch() for chunk in RrdReader(file).stream().filter(content=path)]


def texts(file, path):
    found = []
    for batch in chunks(file, path):
        for field in batch.schema.names:
            if field.endswith("TextDocument:text"):
                found += [row[0] for row in batch.column(field).to_pylist() if row]
    return found


def test_every_step_has_a_tab_with_its_errors_whatever_the_time_is(file, refinement):
    for place, step in enumerate(refinement.ladder.steps):
        assert chunks(file, f"/ladder/{place}/motion")
        assert times(step.error.chi2) in texts(file, f"/ladder/{place}/summary")[0]
    timelines = {name for batch in chunks(file, "/ladder/**") for name in batch.schema.names}
    assert not timelines & {"time", "step"}
    fits = tuple(step_again(refinement, step).fit for step in refinement.ladder.steps)
    stream = rr.RecordingStream("tabs", send_properties=False)
    tab = tabs.ladder(stream, VIEWERS[True], "one", refinement.ladder, fits, refinement.weighing)
    assert [one.name for one in tab.contents] == ["0: usual model", "1: + cubic_stiffness"]
    assert tab.active_tab == 1


def test_each_step_tells_what_it_added_and_why_the_climb_stopped(file):
    (first,), (second,) = (texts(file, f"/ladder/{place}/summary") for place in (0, 1))
    assert "usual model" in first
    assert "cubic_stiffness" not in first
    assert "+ cubic_stiffness" in second
    assert "floor is reached" in second


def test_the_force_map_of_a_cubic_spring_is_a_cubic_less_what_a_line_can_follow(refinement):
    from identify.diagnosis.force_map import force_added

    base, top = (step_again(refinement, step).fit for step in refinement.ladder.steps)
    prepared = refinement.prepared
    added = force_added(prepared, base, top, top.model.terms[-1])
    u = prepared.motion.displacement
    truth = TRUTH[DUFFING.name]["parameters"]["k3"] * u**3
    used = np.abs(prepared.motion.velocity) > 0.05
    line = np.column_stack([u, prepared.motion.velocity, np.sign(prepared.motion.velocity), np.ones_like(u)])
    left = truth - line @ np.linalg.lstsq(line[used], truth[used], rcond=None)[0]
    # The regression along noisy motion finds k3 to some per cent; the two fits weigh the samples a little differently.
    assert np.abs((added - left)[used]).max() < 0.15 * np.abs(left[used]).max()


@pytest.mark.usefixtures("unrendered")
def test_a_session_that_was_not_refined_has_no_ladder(tmp_path):
    settings = Settings(sessions=tmp_path)
    session = open_sessions((str(DUFFING),), settings).sessions[0]
    result, _ = identify_session(session, settings)
    assert not chunks(viewer_tabs.write_view(session, result, settings), "/ladder/**")


def test_where_no_viewer_is_open_none_is_opened_and_nothing_is_written(refinement, monkeypatch):
    monkeypatch.setattr(viewer, "PORT", viewer.free_port())
    monkeypatch.setattr(viewer, "start", None)
    (refinement.session.results / viewer_tabs.VIEW).unlink(missing_ok=True)
    viewer_tabs.show_refined(refinement, Settings())
    assert not (refinement.session.results / viewer_tabs.VIEW).exists()


@pytest.mark.slow
@pytest.mark.filterwarnings(
    "ignore::pytest.PytestUnraisableExceptionWarning"
)  # what shows it outlives the station
def test_a_viewer_that_is_open_is_sent_the_ladder(refinement, tmp_path):
    port, sent = viewer.free_port(), tmp_path / "sent.rrd"
    server = viewer.start("--save", str(sent), "--port", str(port))
    try:
        assert viewer.wait_for(port)
        viewer_tabs.show_refined(refinement, Settings(), port)
        assert any((sent.is_file() and sent.stat().st_size > 100_000) or _wait() for _ in range(100))
    finally:
        server.terminate()
        server.wait(timeout=10)


def _wait():
    import time

    time.sleep(0.1)
