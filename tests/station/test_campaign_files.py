"""A folder of files of one logger: one recipe, numbers from their names and a table, kept and not imported twice."""

import json

import numpy as np
import pytest

from daq.session import Session
from station.campaign.sources import Names
from station.cli import run as station
from station.exits import UsageProblem

RECIPE = """recipe = 1
rate = 100.0
fields = [
  {column = 2, role = "displacement", unit = "deg"},
]
[dialect]
delimiter = ";"
"""


@pytest.fixture
def arms(tmp_path, monkeypatch):
    """Three files whose second column is an angle, which nothing in them says; and a file that is none of them."""
    monkeypatch.chdir(tmp_path)
    folder = tmp_path / "arms"
    folder.mkdir()
    t = np.arange(1500) / 100.0
    for arm in (60, 80, 100):
        noise = np.random.default_rng(arm).normal(0.0, 0.01, t.size)
        angle = 30.0 * np.exp(-0.1 * t) * np.cos(600.0 / arm * t) + noise
        rows = "\n".join(f"{i};{x:.3f};{1e-3 * i:.3f}" for i, x in enumerate(angle))
        (folder / f"{arm}P.txt").write_text(f"eins;zwei{arm};drei\n{rows}\n")
    (folder / "README.md").write_text("# Arms\n")
    (folder / "R.toml").write_text(RECIPE)
    return folder


def campaign(capsys, *words):
    assert station(["campaign", "arms", *words, "--json", "--workers", "1"]) == 0
    printed = capsys.readouterr()
    return json.loads(printed.out), printed.err


def test_a_folder_of_files_runs_through_a_campaign_by_one_recipe(arms, capsys):
    words = ("--recipe", "arms/R.toml", "--names", "{arm:d}P.txt", "--varies", "stiffness, inertia")
    document, told = campaign(capsys, *words)
    assert {row["result"]["session"]: row["conditions"] for row in document["rows"]} == {
        f"{arm}P": {"arm": float(arm)} for arm in (60, 80, 100)
    }
    assert "README.md: its name is not of the form" in told
    assert Session.open(arms.parent / "sessions" / "arms" / "60P").info.varies == ("stiffness", "inertia")
    again, _ = campaign(capsys, *words)
    assert again["done"] == 0
    assert len(list((arms.parent / "sessions" / "arms").glob("*P*"))) == 3
    assert station(["campaign", "arms", *words]) == 0
    printed = capsys.readouterr().out
    assert "arm 80" in printed
    assert "1/s²" in printed
    (arms / "R.toml").write_text(RECIPE.replace("deg", "rad"))
    anew, _ = campaign(capsys, *words)
    assert {row["result"]["session"] for row in anew["rows"]} == {"60P-2", "80P-2", "100P-2"}


def test_a_table_names_the_files_and_one_that_the_recipe_does_not_explain_is_one_line(arms, capsys):
    (arms / "known.csv").write_text("file,length [mm],date\n60P.txt,60,2026-03-01\n80P.txt,81.5,2026-03-02\n")
    stamps = np.cumsum(np.random.default_rng(1).uniform(0.001, 0.5, 400))
    rows = "\n".join(f"{t:.4f};{np.cos(t):.4f}" for t in stamps)
    (arms / "uneven.txt").write_text(f"eins;zwei\n{rows}\n")
    (arms / "R.toml").write_text(
        'recipe = 1\nfields = [{column = 1, role = "time", unit = "0.01 s"}, {column = 2, role = "displacement"}]\n'
    )
    words = ("--recipe", "arms/R.toml", "--metadata", "arms/known.csv")
    document, told = campaign(capsys, *words)
    rows = {row["result"]["session"]: row for row in document["rows"]}
    assert set(rows) == {"60P", "80P", "100P"}
    assert rows["80P"]["conditions"] == {"length [mm]": 81.5}
    assert rows["60P"]["made"].startswith("2026-03-01")
    assert rows["100P"]["conditions"] == {}
    assert "README.md: left out" in told
    assert "uneven.txt: left out: " in told


def test_a_file_that_nothing_explains_ends_with_the_proposed_recipe(arms, capsys):
    (arms / "README.md").unlink()
    assert station(["campaign", "arms", "--recipe", "none.toml"]) == 2
    assert "none.toml" in capsys.readouterr().err
    assert station(["campaign", "arms"]) == 2
    printed = capsys.readouterr()
    assert printed.out.startswith("recipe = 1")
    assert "give that by --recipe" in printed.err
    assert not (arms.parent / "sessions").exists()


def test_numbers_and_texts_are_read_from_names():
    form = Names("{specimen}_{length [mm]:f}mm_{n:d}{}.csv")
    assert form.said("steel_12,5mm_3b.csv") == ({"length [mm]": 12.5, "n": 3.0}, {"specimen": "steel"})
    assert form.said("steel_12,5mm.csv") is None


@pytest.mark.parametrize("pattern", ["{arm}P.txt", "{arm:x}P.txt", "{:d}P.txt"])
def test_a_form_of_names_that_is_none_is_refused_in_words(pattern):
    with pytest.raises(UsageProblem, match="is no field; write"):
        Names(pattern)
