"""A step is worth what it explains: a useless one is said to be, and taken out; the measured curve is a step too."""

import json
import shutil

import numpy as np
import pytest
from hidden import NOTHING

from identify.residual import reaches_floor, would_explain
from mocks.generate import draw
from station.cli import run
from station.results.ladder import KeptLadder


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("station.views.viewer.PORT", 9)  # nobody listens there
    return tmp_path


def released(name, amplitude):
    sample = draw("magnet", 0.02, 5, amplitude=amplitude)
    time = np.arange(len(sample.displacement)) / sample.rate
    table = np.column_stack([time, sample.displacement, sample.acceleration])
    np.savetxt(name, table, delimiter=",", header="time_s,displacement_m,acceleration_m_s2", comments="")


def refined(capsys, *line):
    capsys.readouterr()
    assert run(["refine", *line, "--no-viewer"]) == 0
    return capsys.readouterr().out


@pytest.mark.slow
def test_a_useless_effect_is_said_to_be_one_and_auto_takes_it_out(place, capsys):
    shutil.copy(NOTHING, "calm.csv")
    text = " ".join(refined(capsys, "calm.csv", "--add", "cubic_stiffness").split())
    assert "Cubic stiffness explains nothing (" in text
    assert "floor is reached" not in text
    assert text.endswith("next: station refine sessions/calm --remove cubic_stiffness")
    refined(capsys, "calm", "--auto")
    ladder = KeptLadder.model_validate_json((place / "sessions/calm/results/ladder.json").read_bytes())
    assert ladder.top.removed == "cubic_stiffness"
    assert "cubic_stiffness" not in ladder.top.effects


@pytest.mark.slow
def test_the_measured_curve_of_a_magnet_is_kept_and_predicts_the_next_release(place, capsys):
    released("one.csv", 0.02)
    released("two.csv", 0.018)
    refined(capsys, "one.csv", "--add", "measured_curve")
    kept = json.loads((place / "sessions/one/results/ladder.json").read_text())
    before, after = (step["error"]["chi2"] for step in kept["steps"])
    assert after < 0.1 * before
    model = json.loads((place / "sessions/one/results/model.json").read_text())
    assert model["expressions"][0].startswith("measured_curve = spline(u, ")
    assert run(["validate", "one", "two.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "predicts_better"


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (101.0, 1.0, "100 %"),
        (101.0, 1.1, "99.9 %"),
        (101.0, 40.0, "61 %"),
        (1997.0, 1998.0, "nothing"),
        (5.0, None, "-"),
    ],
)
def test_what_a_suspect_would_explain_is_a_share_of_what_stands_above_the_noise(before, after, words):
    assert would_explain(before, after) == words


def test_a_guessed_floor_is_doubted():
    assert reaches_floor(1.1, 0.05)
    assert not reaches_floor(1.4, 0.05)
    assert not reaches_floor(None, 0.05)
