"""Validate: a model file, or what a session keeps, predicts other sessions; what does not suit is said in a sentence."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
from many_sessions import make_noise, make_session
from rich.console import Console

from daq.errors import NotWritable
from daq.recording import Channel, Recording
from daq.session import Session
from daq.storage import Lock
from mocks.generate import draw
from station import exits
from station.cli import run
from station.results.documents import read_document, to_text
from station.results.ladder import KeptLadder, KeptStep, write_ladder
from station.results.models import EffectEntry, ModelFile, Value
from station.results.validation_document import NAME, ValidationDocument
from station.text import validation_text
from station.text.layout import show

K, MU_0, MU_1, K3 = 613.6, 0.05, 0.25, 4e4


def model_file(k3: float = K3, unit: str = "m") -> ModelFile:
    """Return the true model of the bench, with a hardening spring of any strength."""
    entries = (
        ("linear_stiffness", "k", K, "1/s^2"),
        ("coulomb_friction", "mu_0", MU_0, f"{unit}/s^2"),
        ("viscous_damping", "mu_1", MU_1, "1/s"),
        ("cubic_stiffness", "k3", k3, f"1/({unit}^2 s^2)"),
    )
    return ModelFile(
        effects=tuple(
            EffectEntry(effect=effect, parameters={name: Value(value=value, unit=units)})
            for effect, name, value, units in entries
        )
    )


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Return a folder with sessions of one bench ("a", "b", "c"), one without a release ("short"), and two models."""
    folder = tmp_path_factory.mktemp("validating")
    for seed, (name, amplitude) in enumerate({"a": 0.02, "b": -0.009, "c": 0.012}.items()):
        pinned = {"cubic_stiffness": {"k3": K3}}
        fixed = {"stiffness": K, "mu_0": MU_0, "mu_1": MU_1, "seconds": 4.0}
        made = draw("cubic_stiffness", 0.01, seed, amplitude=amplitude, parameters=pinned, **fixed)
        make_session(folder / "sessions" / name, made.rate, np.array([made.displacement, made.acceleration]))
    make_noise(folder / "sessions" / "short")
    (folder / "right.json").write_text(to_text(model_file()))
    (folder / "wrong.json").write_text(to_text(model_file(k3=20 * K3)))
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield folder


@pytest.fixture(scope="module")
def kept(bench):
    """Return the bench where the session "a" keeps the true model as its ladder's present step."""
    step = KeptStep(
        model=model_file(), error={"chi2_std": 0.05}, nuisances={}, floor_percent=0.5, at_floor=True
    )
    write_ladder(Session.open(bench / "sessions" / "a"), KeptLadder(format=1, steps=(step,), present=0))
    return bench


def told(capsys, *arguments, code=exits.DONE):
    assert run(["validate", *map(str, arguments), "--json"]) == code
    return json.loads(capsys.readouterr().out)


def refused(capsys, *arguments, code=exits.USAGE):
    assert run(["validate", *map(str, arguments)]) == code
    sentence = capsys.readouterr().err.strip().splitlines()[-1]
    assert sentence.startswith("station: ")
    return sentence


def test_the_true_model_in_a_file_predicts_better_and_what_is_too_short_is_skipped(bench, capsys):
    found = told(capsys, "right.json", "b", "c", "short")
    assert (found["verdict"], found["better"], found["usual_from"]) == (
        "predicts_better",
        2,
        "the_other_releases",
    )
    assert [one["session"] for one in found["sessions"]] == ["b", "c"]
    for one in found["sessions"]:
        # The floor is known to a tenth; the model is the truth.
        assert one["model"]["chi2"] == pytest.approx(1.0, abs=0.3)
        assert one["usual"]["motion_percent"] > one["model"]["motion_percent"]
    (skipped,) = found["skipped"]
    assert skipped["session"] == "short"
    kept = read_document(Session.open(bench / "sessions" / "b"), NAME, ValidationDocument, "")
    assert kept.plain() == found
    assert not (bench / "sessions" / "short" / "results" / NAME).exists()


def test_of_a_session_that_may_not_be_written_the_prediction_is_told_all_the_same(bench, capsys, monkeypatch):
    def read_only(lock, wait_s=0.2):
        raise NotWritable("the disk is read-only")

    monkeypatch.setattr(Lock, "acquire", read_only)
    assert run(["validate", "right.json", "c", "--json"]) == exits.DONE
    said = capsys.readouterr()
    assert json.loads(said.out)["better"] == 1
    assert said.err.count("note: the disk is read-only; what is found is not kept") == 1


def test_a_wrong_model_predicts_worse_and_that_is_no_failure(bench, capsys):
    found = told(capsys, "wrong.json", "b", "c", "--hold")
    assert (found["verdict"], found["worse"], found["held"]) == ("predicts_worse", 2, True)
    assert all(one["model"]["varied_percent"] == {} for one in found["sessions"])


def test_a_session_gives_the_model_of_its_ladder_and_is_not_predicted_itself(kept, capsys):
    found = told(capsys, "a", "a", "b")
    assert (found["source"], found["fitted_to"], found["usual_from"]) == ("a", ["a"], "the_same_releases")
    assert found["skipped"] == [{"session": "a", "reason": "the model was fitted to it"}]
    by_file = told(capsys, Path("sessions") / "a" / "results" / "model.json", "b")
    assert by_file["fitted_to"] == ["a"]
    assert by_file["sessions"] == found["sessions"]


def test_it_fits_a_terminal_with_the_verdict_first(bench, capsys):
    document = ValidationDocument.model_validate(told(capsys, "right.json", "b", "c", "short"))
    out = io.StringIO()
    show(Console(file=out, width=80), validation_text.told(document))
    lines = out.getvalue().strip().splitlines()
    assert lines[0].strip().startswith("Predicts better than the usual model on 2 of 2 releases")
    assert max(len(line.rstrip()) for line in lines) <= 80
    assert any(line.strip().startswith("skipped") and "short" in line for line in lines)


def test_nothing_that_can_be_predicted_ends_with_8(bench, capsys):
    assert "no session can be predicted: short: " in refused(
        capsys, "right.json", "short", code=exits.NOT_IDENTIFIABLE
    )


def test_a_session_in_another_unit_is_refused_in_one_sentence(bench, capsys):
    time = np.arange(1500) / 100.0
    angle = 0.3 * np.exp(-0.1 * time) * np.cos(6.0 * time)
    channel = (Channel("angle", "displacement", "rad"),)
    Session.create_imported(
        bench / "sessions" / "angle", Recording(100.0, channel, angle[None], np.ones(1500, dtype=bool)), None
    )
    sentence = refused(capsys, "right.json", "angle")
    assert (
        "angle has a displacement in rad, the model another unit: coulomb_friction.mu_0 is in m/s^2"
        in sentence
    )


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("a", "a"), "a: the model was fitted to it; give sessions that it has not seen"),
        (("b", "c"), "b keeps no model but the usual one"),
        (("right.json", "b", "b"), "one session was given twice"),
        (("none.json", "b"), "none.json: there is no such model file or session"),
        (("empty.json", "b"), "the model empty.json: "),
    ],
)
def test_what_cannot_be_validated_is_refused_in_one_sentence(kept, capsys, arguments, said):
    (kept / "empty.json").write_text("{}")
    assert said in refused(capsys, *arguments)
