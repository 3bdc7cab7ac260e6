"""The curves of a session, from its results to the page and the report."""

import base64
import shutil
from types import SimpleNamespace

import numpy as np
import pytest
from hidden import DUFFING, TRUTH

from daq.session import Session
from station.operations.refining import open_refinement
from station.operations.session_set import kept_curves
from station.report.loop import suspects
from station.results.diagnosis_document import CurveDocument, read_diagnosis
from station.settings import Settings
from station.story.engineering_values import UNKNOWN, Weighing
from station.views import diagnosis_figures


@pytest.fixture(scope="module")
def kept(tmp_path_factory, diagnosed):
    """Return a session with a Duffing spring and its diagnosis, twice side by side, and its curves."""
    settings = Settings(sessions=tmp_path_factory.mktemp("sessions"))
    shutil.copytree(diagnosed, settings.sessions / "again")
    session = Session.open(shutil.copytree(diagnosed, settings.sessions / DUFFING.stem))
    refinement = open_refinement(session, settings)
    document = read_diagnosis(session)
    shown = kept_curves(refinement, document, settings)
    return SimpleNamespace(
        settings=settings, session=session, refinement=refinement, document=document, shown=shown
    )


def backbone(amplitude):
    """Return sqrt(k + 3/4 k3 A^2) of the hidden Duffing spring, Hz."""
    truth = TRUTH[DUFFING.name]
    cubic = 0.75 * truth["parameters"]["k3"] * np.asarray(amplitude) ** 2
    return np.sqrt(truth["stiffness_per_mass"] + cubic) / (2.0 * np.pi)


def again(kept, **changed):
    """Return the curves with another document."""
    refinement, document = kept.refinement, kept.document.model_copy(update=changed)
    return kept_curves(refinement, document, kept.settings)


def test_the_named_model_follows_the_curve_where_the_usual_one_does_not(kept):
    (measured,) = kept.shown[1].releases
    usual, named = kept.shown[1].laws[:2]
    assert (usual.law.role, named.law.name) == ("usual", "cubic_stiffness")
    large = measured.amplitude > 0.5 * measured.amplitude.max()  # below, dry friction bends the frequency too
    rise = np.ptp(backbone(measured.amplitude[large]))
    for laid, low, high in ((named, 0.0, 0.1), (usual, 0.3, 2.0)):
        (law,) = laid.curves
        off = np.abs(law.frequency[: large.sum()] - backbone(measured.amplitude[large])).max()
        assert low * rise <= off < high * rise + 2e-3


def test_a_document_of_before_draws_the_usual_model_alone(kept):
    plain = kept.document.plain()
    assert plain.pop("final")["effects"][-1]["effect"] == "cubic_stiffness"
    old = type(kept.document).model_validate(plain)
    shown = again(kept, final=old.final)
    assert [laid.law.role for laid in shown[1].laws] == ["usual"]


def test_sessions_diagnosed_together_are_in_one_picture_and_those_that_are_gone_are_not(kept):
    shown = again(kept, sessions=["again", DUFFING.stem, "gone", "../sessions/again"])
    assert shown[0] == (DUFFING.stem, "again")
    assert [len(laid.curves) for laid in shown[1].laws] == [2] * len(shown[1].laws)


def test_a_rival_is_laid_over_in_place_of_what_was_named(kept):
    shown = again(kept, rivals=["quintic_stiffness", "settling_stiffness"])
    rivals = [laid.law for laid in shown[1].laws if laid.law.role == "rival"]
    assert [law.name for law in rivals] == ["quintic_stiffness", "settling_stiffness"]
    assert all("cubic_stiffness" not in law.model for law in rivals)


def test_the_free_form_of_a_pendulum_over_time_is_a_torque():
    curve = CurveDocument(coordinate="time", unit="s", position=[0, 1], force_per_mass=[0, 1], std=[0, 0])
    for unit, word in (("rad", "torque"), ("m", "force")):
        axis = diagnosis_figures.shape(curve, Weighing(unit=unit)).axes[0]
        assert f"missing {word} per unit" in axis.get_ylabel()
    drifting = curve.model_copy(update={"where": "at 0.016 m"})
    assert "at 0.016 m" in diagnosis_figures.shape(drifting, Weighing(unit="m")).axes[0].get_ylabel()


def test_the_report_shows_what_was_found(kept):
    picture = diagnosis_figures.curves(kept.shown[1], kept.shown[0]).uri
    drawing = base64.b64decode(picture.partition(",")[2])
    assert b"<svg" in drawing
    assert b"with cubic stiffness" in drawing
    known = {"diagnosis": kept.document, "curves": kept.shown, "weighing": UNKNOWN}
    found = SimpleNamespace(maps=(), compared=None, left_out={}, **known)
    captions = [part.caption for part in suspects(found) if part.kind == "figure"]
    assert any("Thick line: the model with the named effects" in caption for caption in captions)
