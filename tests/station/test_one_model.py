"""One model and one floor through the whole program: what was identified at chosen orders is what everything begins with."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from hidden import DUFFING

from identify.effects.families import FAMILIES
from mocks.generate import draw
from station.cli import run
from station.operations.current_model import current_model
from station.operations.identifying import kept_options
from station.operations.refining import add, open_refinement
from station.report.findings import gather
from station.results.sessions import open_session
from station.settings import Settings
from station.story.pipeline import silent
from station.story.preparation import prepare_session

USUAL = ["linear_stiffness", "coulomb_friction", "viscous_damping"]
CUBIC = ["linear_stiffness", "cubic_stiffness", "coulomb_friction", "viscous_damping"]
QUIET = ["--no-viewer", "--json"]


def said(capsys, *line):
    assert run(list(line)) == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("orders")
    shutil.copy(DUFFING, folder / "duffing.csv")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert (
            run(["identify", "duffing.csv", "--stiffness-orders", "1,3", "--max-order", "1", "--json"]) == 0
        )
    return folder


@pytest.fixture
def chosen(made, tmp_path, monkeypatch, capsys):
    """A copy of a session whose spring hardens, identified at orders that the operator chose; the third among them."""
    shutil.copytree(made / "sessions", tmp_path / "sessions")
    monkeypatch.chdir(tmp_path)
    capsys.readouterr()
    return open_session("duffing", Settings().sessions)


def test_every_command_begins_with_the_orders_that_were_chosen(chosen, capsys):
    begun = current_model((chosen,))
    assert sorted(begun.model.names) == sorted(CUBIC)
    assert "identified" in begun.words
    refinement = open_refinement(chosen, Settings())
    assert refinement.ladder.top.effects == list(begun.model.names)
    assert "identified" in refinement.ladder.top.begun_with
    compared = said(capsys, "compare", "duffing", "--json")
    assert sorted(compared["model"]["effects"]) == sorted(CUBIC)
    assert "identified" in compared["model_is"]
    found = gather(chosen, Settings(), silent)
    assert sorted(found.compared.baseline.fit.model.names) == sorted(CUBIC)


@pytest.mark.slow
def test_the_usual_model_can_be_asked_for_all_the_same(chosen, capsys):
    assert said(capsys, "compare", "duffing", "--model", "usual", "--json")["model"]["effects"] == USUAL
    ladder = said(capsys, "refine", "duffing", "--model", "usual", *QUIET)
    assert ladder["steps"][0]["effects"] == USUAL


def test_orders_that_nobody_chose_leave_the_usual_model_to_begin_with_and_say_so(chosen, capsys):
    assert (
        run(["identify", "duffing", "--json"]) == 0
    )  # with the orders that are tried anyway: it finds the cubic too
    begun = current_model((chosen,))
    assert list(begun.model.names) == USUAL
    assert "cubic stiffness" in begun.remark
    assert "--model identified" in begun.remark


@pytest.mark.slow
def test_a_session_that_is_identified_again_on_the_way_keeps_its_orders(chosen, capsys):
    options = kept_options(chosen, Settings())
    assert (options.max_order, options.stiffness_orders) == (1, (1, 3))
    assert run(["table", "duffing"]) == 0
    assert kept_options(chosen, Settings()) == options


def test_no_model_was_identified_yet_is_told(tmp_path, monkeypatch, capsys):
    shutil.copy(DUFFING, tmp_path / "duffing.csv")
    monkeypatch.chdir(tmp_path)
    assert run(["diagnose", "duffing.csv", "--model", "identified", *QUIET]) == 2
    assert "no model was identified yet" in capsys.readouterr().err


@pytest.mark.slow
def test_a_suspect_is_nothing_that_the_model_has_and_nothing_is_missing(chosen, capsys):
    document = said(capsys, "diagnose", "duffing", *QUIET)
    assert sorted(document["model"]["effects"]) == sorted(CUBIC)
    assert not {one["effect"] for one in document["suspects"]} & set(CUBIC)
    assert document["verdict"] == "nothing_missing"


def test_a_fit_begins_again_with_the_states_that_its_release_had_and_other_releases_do_not(chosen):
    refinement = open_refinement(chosen, Settings())
    add(refinement, "second_mass")
    known, prepared = current_model((chosen,)), refinement.prepared
    known = replace(known, states={"second_mass.state0": 0.5})
    assert known.start((prepared,))["second_mass.state0"] == 0.5
    assert 0.5 not in known.start((prepared, prepared)).values()


def test_a_second_mass_that_swung_before_is_compared_as_it_was_refined(tmp_path, monkeypatch, capsys):
    time = np.arange(256) / 40.0
    moves = 5.0 * np.exp(-0.05 * time) * np.cos(14.2 * time) + 0.4 * np.exp(-0.1 * time) * np.cos(
        4.6 * time + 1.0
    )
    noise = 0.1 * np.random.default_rng(1).standard_normal(256)
    rows = [f"{t:.3f},{a:.5f}" for t, a in zip(time, moves + noise, strict=True)]
    (tmp_path / "two.csv").write_text("\n".join(["time [s],acceleration [m/s^2]", *rows]))
    monkeypatch.chdir(tmp_path)
    assert run(["import", "two.csv"]) == 0
    capsys.readouterr()
    refined = said(capsys, "refine", "two", "--add", "second_mass", *QUIET)["steps"][-1]["error"]
    compared = said(capsys, "compare", "two", "--json")["error"]
    assert compared["motion_percent"] == pytest.approx(refined["motion_percent"], rel=0.02)


def test_one_record_has_one_floor_whatever_model_is_judged(chosen, capsys):
    """A model that explains the record knows its noise better; the floor that is stated does not narrow with it."""
    width = prepare_session(chosen, Settings()).floor_std
    assert width is not None
    kept = json.loads((chosen.results / "identification.json").read_text())
    usual = said(capsys, "compare", "duffing", "--model", "usual", "--json")
    refinement = open_refinement(chosen, Settings(), reset=True)
    ladder = add(refinement, "quadratic_damping")
    stated = [
        kept["adequacy"]["chi2_std"],
        usual["error"]["chi2_std"],
        *(r.error.chi2_std for r in ladder.steps),
    ]
    assert stated == pytest.approx([width] * len(stated))


@pytest.mark.slow
def test_a_long_record_is_judged_in_its_pieces_by_every_command_and_one_run_says_why(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    time = np.arange(0.0, 70.0, 0.02)  # 105 cycles of a viscous decay whose phase drifts, which no force does
    phase = 2.0 * np.pi * 1.5 * time + 0.15 * np.sin(2.0 * np.pi * time / 23.0)
    noise = np.random.default_rng(3).normal(0.0, 2e-5, len(time))
    table = np.column_stack([time, 0.02 * np.exp(-0.01 * time) * np.cos(phase) + noise])
    np.savetxt("long.csv", table, delimiter=",", header="time_s,displacement_m", comments="", fmt="%.9g")
    own = said(capsys, "identify", "long.csv", "--json")["adequacy"]
    compared = said(capsys, "compare", "long", "--json")
    assert compared["pieces"] > 1
    assert compared["error"]["chi2"] == pytest.approx(
        own["chi2"], rel=0.02
    )  # another start, the same minimum
    assert compared["error"]["motion_percent"] == pytest.approx(own["motion_percent"], rel=0.02)
    assert compared["error"]["chi2_std"] == own["chi2_std"]
    assert compared["one_run"]["chi2"] > 1.5 * compared["error"]["chi2"]
    assert run(["compare", "long", "--full"]) == 0
    assert "judged in" in capsys.readouterr().out


@pytest.mark.parametrize("law", [family.effect.name for family in FAMILIES])
def test_a_law_between_the_names_is_added_by_its_name_and_kept_and_read_again(
    law, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    sample = draw(law, 0.02, 77)
    time = np.arange(len(sample.displacement)) / sample.rate
    columns = np.column_stack([time, sample.displacement, sample.acceleration])
    names = "time (s),displacement (m),acceleration (m/s^2)"
    np.savetxt("release.csv", columns, delimiter=",", header=names, comments="")
    said(capsys, "import", "release.csv", "--json")
    refined = said(capsys, "refine", "release", "--add", law, "--json")
    assert refined["steps"][-1]["effects"][-1] == law
    compared = said(capsys, "compare", "release", "--json")
    assert compared["model"]["effects"][-1] == law
    assert compared["error"]["chi2"] < 1.3  # the noise is known to 1.2 here
