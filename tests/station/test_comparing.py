"""Comparing a session and telling of effects, from the command line; the session is simulated by the testbed."""

import json

import numpy as np
import pytest

from identify.effects.library import NAMED
from mocks.generate import draw
from station.cli import run

MASS = 21.36


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with a release of a hardening or softening spring, imported from a text file."""
    made = tmp_path_factory.mktemp("compare")
    sample = draw("cubic_stiffness", 0.01, 3)
    time = np.arange(len(sample.displacement)) / sample.rate
    table = np.column_stack([time, sample.displacement, sample.acceleration])
    header = "time_s,displacement_m,acceleration_m_s2"
    np.savetxt(made / "cubic.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
    (made / "truth.json").write_text(json.dumps(sample.truth["parameters"]))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        assert run(["import", "cubic.csv", "--mass", str(MASS)]) == 0
    return made


@pytest.fixture
def inside(folder, monkeypatch):
    monkeypatch.chdir(folder)
    return folder


def test_compare_tells_the_worst_places_in_newtons_within_80_columns(inside, capsys):
    line = ["compare", "cubic.csv", "--model", "usual"]
    assert run(line) == 0
    short = [row for row in capsys.readouterr().out.splitlines() if row.strip()]
    assert len(short) <= 14
    assert run([*line, "--full"]) == 0
    text = capsys.readouterr().out
    k3 = json.loads((inside / "truth.json").read_text())["k3"]
    told = " ".join(text.split())
    assert f"{'stiffer' if k3 > 0 else 'softer'} than the model, in both directions" in told
    assert " N " in told
    assert all(len(line) <= 80 for line in text.splitlines())


def test_compare_as_json_holds_errors_places_and_cycles_and_is_kept(inside, capsys):
    assert run(["compare", "cubic.csv", "--model", "usual", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["error"]["chi2"] > 10
    assert document["error"]["force_mse_percent"] > document["floor_percent"]
    assert document["noise_floor"]["displacement"]["source"]
    assert document["places"][0]["significance"] >= document["places"][-1]["significance"]
    assert len(document["cycles"]["time_s"]) == len(document["cycles"]["energy_error"])
    kept = json.loads((inside / "sessions" / "cubic" / "results" / "comparison.json").read_text())
    assert kept == document


def test_a_session_is_compared_with_its_current_model_or_the_one_that_is_asked_for(inside, capsys):
    def said(*line):
        assert run([*line, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    own = said("identify", "cubic.csv")["adequacy"]
    assert "cubic_stiffness" in own["effects"]  # the backbone bends
    first = said("compare", "cubic.csv")
    assert (first["model_is"], len(first["model"]["effects"])) == ("the usual model", 3)
    assert "cubic stiffness" in first["model_remark"]
    identified = said("compare", "cubic.csv", "--model", "identified")
    assert identified["model"]["effects"] == own["effects"]
    assert identified["error"]["chi2"] == pytest.approx(own["chi2"], abs=0.05)
    assert run(["compare", "cubic", "--model", "refined"]) == 2
    assert "no model was refined yet" in capsys.readouterr().err
    (_, step) = said("refine", "cubic", "--add", "cubic_stiffness", "--no-viewer")["steps"]
    for line in (("compare", "cubic"), ("compare", "cubic", "--model", "refined")):
        refined = said(*line)
        assert refined["model_is"] == "the refined model"
        assert refined["model"]["effects"] == step["effects"]
        assert refined["error"]["chi2"] == pytest.approx(step["error"]["chi2"], abs=0.05)
    assert said("compare", "cubic", "--model", "usual")["error"]["chi2"] == first["error"]["chi2"]
    assert run(["info", "cubic"]) == 0
    assert "the refined model: linear stiffness" in capsys.readouterr().out


def test_a_model_file_that_does_not_exist_is_refused_in_one_sentence(inside, capsys):
    assert run(["compare", "cubic.csv", "--model", "none.json"]) != 0
    assert "none.json" in capsys.readouterr().err


def test_effects_lists_the_whole_library(capsys):
    assert run(["effects"]) == 0
    text = capsys.readouterr().out
    assert all(effect.name in text for effect in NAMED)
    assert all(len(line) <= 80 for line in text.splitlines())


@pytest.mark.parametrize("effect", NAMED, ids=lambda effect: effect.name)
def test_every_effect_tells_of_itself_within_80_columns(effect, capsys):
    assert run(["effects", effect.name]) == 0
    text = capsys.readouterr().out
    assert all(parameter.name in text for parameter in effect.parameters)
    assert "proof" in text
    assert all(len(line) <= 80 for line in text.splitlines())


def test_an_unknown_effect_is_answered_with_where_the_names_are(capsys):
    assert run(["effects", "bogus"]) != 0
    assert "see `station effects`" in capsys.readouterr().err


def test_effects_in_json_have_their_parameters_and_what_they_borrow(capsys):
    assert run(["effects", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["effects"]
    assert [one["name"] for one in listed] == [effect.name for effect in NAMED]
    assert all(one["parameters"] and one["tell"] and one["proof"] for one in listed)
    assert any(one["borrows"] for one in listed)
