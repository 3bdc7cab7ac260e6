"""The examples: they are what their script makes, and a newcomer without a board gets through with them."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest

from station import exits
from station.cli import run
from station.operations.examples import EXAMPLES, examples_folder

FOLDER = Path(__file__).resolve().parents[2] / "examples"
LARGEST = 2 << 20


def script():
    found = importlib.util.spec_from_file_location("make_examples", FOLDER / "make.py")
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", list(script().SIMULATED))
def test_the_simulated_ones_are_what_the_testbed_gives(name):
    made = np.array([line.split(",") for line in script().simulated(name).splitlines()[1:]], dtype=float)
    kept = np.loadtxt(FOLDER / f"{name}.csv", delimiter=",", skiprows=1)
    # Written to 8 and 6 decimals; on another processor the last one may be another, or a code of the converter.
    np.testing.assert_allclose(kept, made, rtol=0, atol=1e-3)
    assert np.mean(np.abs(kept - made) < 2e-6) > 0.999


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_every_example_is_identified_by_one_command(example, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["demo", "--example", example.name, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    methods = told["identification"]
    assert methods["restoring_force"] is not None
    assert Path(told["session"]).name == example.name
    if example.mass_kg is not None:
        assert methods["record"]["mass_kg"] == example.mass_kg
    if example.name == "simulated_plain":
        assert run(["demo", "--example", example.name]) == 0  # a second time it is opened
        assert [path.name for path in (tmp_path / "sessions").iterdir()] == [example.name]


def test_the_list_names_every_example(capsys):
    assert run(["demo", "--list"]) == 0
    text = capsys.readouterr().out
    assert all(example.name in text and example.about in text for example in EXAMPLES)
    assert all(len(line) <= 80 for line in text.splitlines())


def test_an_example_that_is_not_there_is_a_sentence_and_code_2(capsys):
    assert run(["demo", "--example", "moon"]) == exits.USAGE
    said = capsys.readouterr().err.strip()
    assert len(said.splitlines()) == 1
    assert "simulated_plain" in said


def test_every_file_is_described_with_its_source_and_all_are_small():
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    files = [path for path in FOLDER.iterdir() if path.is_file()]
    assert examples_folder() == FOLDER
    assert all(f"`{path.name}`" in page for path in files if path.name != "README.md")
    assert {example.file for example in EXAMPLES} == {p.name for p in files} - {"README.md", "make.py"}
    assert sum(path.stat().st_size for path in files) < LARGEST
