"""The heart of the station by its commands: something is hidden, and is found, added, and gone back on."""

import contextlib
import io
import json
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from bench import readme
from daq.capture import CaptureSettings, capture
from daq.session_info import SessionInfo
from station.cli import run
from station.operations import mystery
from station.operations.simulated_board import simulated_board

ROOT = Path(__file__).resolve().parents[2]
HIDDEN = ROOT / "tests" / "data" / "hidden"
TRUTH = {entry["file"]: entry for entry in json.loads((HIDDEN / "truth.json").read_text(encoding="utf-8"))}


@dataclass(frozen=True)
class Told:
    """What the demo of a mystery printed, and what it had found."""

    text: str
    solved: mystery.Solved


def station(*arguments):
    """Run a command of the station in this process; return what it printed on stdout."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run([str(argument) for argument in arguments])
    assert code == 0, err.getvalue()
    return out.getvalue()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("mystery")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        patch.delenv("DISPLAY", raising=False)
        patch.delenv("WAYLAND_DISPLAY", raising=False)
        patch.setattr("station.views.viewer.PORT", 9)  # nobody listens there
        yield made


@pytest.fixture(scope="module")
def told(folder):
    """Run the mystery of the README once, and keep what it found beside what it said."""
    kept, solve = [], mystery.solve

    def keeping(*given, **how):
        kept.append(solve(*given, **how))
        return kept[0]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mystery, "solve", keeping)
        text = station("demo", "--mystery", 7, "--speed", 0, "--no-viewer")
    return Told(text, kept[0][0])


def test_the_mystery_that_newcomers_run_is_solved(told, monkeypatch):
    monkeypatch.setattr(mystery, "solve", lambda *given, **how: (told.solved, None))  # not a second time
    document = json.loads(station("demo", "--mystery", 7, "--json", "--no-viewer"))
    hidden = document["hidden"]
    assert document["seed"] == 7
    assert document["right"]
    assert document["diagnosis"]["named"] == [hidden["effect"]]
    top = document["ladder"]["steps"][-1]
    assert abs(top["error"]["chi2"] - 1.0) < 4 * top["error"]["chi2_std"]
    for name, value in hidden["parameters"][hidden["effect"]].items():
        found = top["parameters"][f"{hidden['effect']}.{name}"]
        assert abs(found["value"] - value) < 4 * found["std"]


def test_the_mystery_is_told_as_a_story_and_the_answer_comes_last(told):
    order = [
        told.text.index(word)
        for word in ("1. COMPARE", "2. DIAGNOSE", "3. ADD", "4. WHAT WAS HIDDEN", "FOUND: ")
    ]
    assert order == sorted(order)
    assert all(len(line) <= 80 for line in told.text.splitlines() if "sessions/" not in line)


def test_the_samples_of_a_mystery_are_those_of_its_seed_at_any_speed(told, tmp_path):
    settings = CaptureSettings(check_clock=False, info=SessionInfo(mass_kg=mystery.MASS_KG))
    with simulated_board(7, 20.0, module=mystery.BOARD) as port:
        again = capture(port, settings, tmp_path / "again").recording()
    np.testing.assert_array_equal(again.samples, told.solved.session.recording().samples)


def test_the_session_is_named_as_in_the_readme(told):
    assert json.loads(station("info", "mystery_7", "--json"))["session"] == str(told.solved.session.folder)


def numbers(text):
    return [float(found) for found in re.findall(r"\d+\.?\d*", text)]


def test_the_figures_of_the_readme_are_those_that_the_mystery_gives(told):
    made = readme.block(told.solved)
    written = readme.inside((ROOT / "README.md").read_text(encoding="utf-8"))
    assert re.sub(r"[\d.█▏▎▍▌▋▊▉]+", "#", written) == re.sub(r"[\d.█▏▎▍▌▋▊▉]+", "#", made)
    # Three figures are written; the last may be another where another processor rounds otherwise.
    assert numbers(written) == pytest.approx(numbers(made), rel=0.011)


@pytest.mark.slow
def test_two_hidden_effects_are_both_found_by_climbing(folder):
    file = HIDDEN / "release_02.csv"
    ladder = json.loads(station("refine", file, "--auto", "--json", "--no-viewer"))
    added = {step["added"] for step in ladder["steps"] if step["added"]}
    assert added == set(TRUTH[file.name]["hidden"].split("+"))
    assert ladder["verdict"] == "nothing_missing"
    assert "floor" in ladder["stopped_because"]
    errors = [step["error"]["chi2"] for step in ladder["steps"]]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1.2
    viewed = json.loads(station("view", "release_02", "--no-viewer", "--json"))
    assert (folder / viewed["recording"]).stat().st_size > 100_000
