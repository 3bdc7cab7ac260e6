"""The heart of the station by its commands: something is hidden, and is found, added, and gone back on."""

import json
import os
import subprocess
import sys
from pathlib import Path

HIDDEN = Path(__file__).resolve().parent.parent / "data" / "hidden"
TRUTH = {entry["file"]: entry for entry in json.loads((HIDDEN / "truth.json").read_text(encoding="utf-8"))}
HEADLESS = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
HEADLESS |= {"STATION_VIEWER": "rerun+http://127.0.0.1:9/proxy"}


def station(*arguments, cwd):
    done = subprocess.run(
        [sys.executable, "-m", "station", *map(str, arguments)],
        capture_output=True, text=True, cwd=cwd, env=HEADLESS, timeout=180, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr
    return done


def test_the_mystery_that_newcomers_run_is_solved(tmp_path):
    told = json.loads(station("demo", "--mystery", 7, "--speed", 0, "--json", cwd=tmp_path).stdout)
    hidden = told["hidden"]
    assert told["seed"] == 7
    assert told["right"]
    assert told["diagnosis"]["named"] == [hidden["effect"]]
    top = told["ladder"]["rungs"][-1]
    assert abs(top["error"]["chi2"] - 1.0) < 4 * top["error"]["chi2_std"]
    for name, value in hidden["parameters"][hidden["effect"]].items():
        found = top["parameters"][f"{hidden['effect']}.{name}"]
        assert abs(found["value"] - value) < 4 * found["std"]


def test_the_mystery_is_told_as_a_story_and_the_answer_comes_last(tmp_path):
    text = station("demo", "--mystery", 7, "--speed", 0, "--no-viewer", cwd=tmp_path).stdout
    order = [
        text.index(word) for word in ("1. COMPARE", "2. DIAGNOSE", "3. ADD", "4. WHAT WAS HIDDEN", "FOUND: ")
    ]
    assert order == sorted(order)
    assert all(len(line) <= 80 for line in text.splitlines() if "sessions/" not in line)


def test_two_hidden_effects_are_both_found_by_climbing(tmp_path):
    file = HIDDEN / "release_02.csv"
    ladder = json.loads(station("refine", file, "--auto", "--json", "--no-viewer", cwd=tmp_path).stdout)
    added = {rung["added"] for rung in ladder["rungs"] if rung["added"]}
    assert added == set(TRUTH[file.name]["hidden"].split("+"))
    assert ladder["verdict"] == "nothing_missing"
    assert "floor" in ladder["stopped_because"]
    errors = [rung["error"]["chi2"] for rung in ladder["rungs"]]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 1.2
    viewed = json.loads(station("view", "release_02", "--no-viewer", "--json", cwd=tmp_path).stdout)
    assert (tmp_path / viewed["recording"]).stat().st_size > 100_000
