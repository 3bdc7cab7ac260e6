"""Diagnose and refine, as their documents and their words say it, on releases that another program has simulated."""

import io
import json
import re
import shutil
from types import SimpleNamespace

import pytest
from hidden import DRIFT, DUFFING, NOTHING, TRUTH
from rich.console import Console

from identify.formatting import plain_name, three_figures
from station import exits
from station.cli import run
from station.results.diagnosis_document import DiagnosisDocument
from station.results.ladder import KeptLadder
from station.story.engineering_values import UNKNOWN
from station.text import diagnosis_text, ladder_text
from station.text.layout import show
from station.text.numbers import change, probability
from station.workbench.parts import part

VERDICTS = (
    "missing_effect",
    "sensor_fault",
    "nothing_missing",
    "unknown_effect",
    "unconfirmed",
    "driven",
    "not_enough_data",
)


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """Return a folder in which the release with a Duffing spring has been diagnosed and refined."""
    folder = tmp_path_factory.mktemp("bench")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.delenv("DISPLAY", raising=False)
        patch.delenv("WAYLAND_DISPLAY", raising=False)
        patch.setattr("station.views.viewer.PORT", 9)  # nobody listens there
        yield folder


def told(capsys, *arguments, code=0):
    assert run([*map(str, arguments), "--json"]) == code
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def diagnosis(bench, diagnosed):
    session = shutil.copytree(diagnosed, bench / "sessions" / DUFFING.stem)
    return json.loads((session / "results" / "diagnosis.json").read_text())


def test_the_document_has_the_keys_that_other_programs_rely_on(diagnosis):
    assert diagnosis["verdict"] in VERDICTS
    assert set(diagnosis["error"]) >= {"force_mse_percent", "motion_percent", "chi2"}
    assert isinstance(diagnosis["explanation"], str)
    assert isinstance(diagnosis["next_experiment"], str)
    assert diagnosis["noise_floor"]["channels"]["displacement"]["unit"] == "m"
    assert diagnosis["model"]["effects"] == ["linear_stiffness", "coulomb_friction", "viscous_damping"]
    for suspect in diagnosis["suspects"]:
        assert suspect["kind"] in ("physics", "sensor")
        assert isinstance(suspect["confusable_with"], list)
        assert suspect["error_after"] is None or suspect["error_after"] >= 0
        for parameter in suspect["parameters"].values():
            assert set(parameter) == {"value", "std", "unit"}


def test_the_hidden_spring_is_named_with_its_parameter(diagnosis):
    truth = TRUTH[DUFFING.name]
    first = diagnosis["suspects"][0]
    assert diagnosis["verdict"] == "missing_effect"
    assert diagnosis["named"] == [truth["hidden"]] == [first["effect"]]
    found = first["parameters"]["k3"]
    # Four standard errors: one record, and the seed of its noise was drawn once.
    assert found["value"] == pytest.approx(truth["parameters"]["k3"], abs=4 * found["std"])
    assert first["error_after"] < 1.0 + 4 * diagnosis["noise_floor"]["chi2_std"]


def test_the_first_suspect_is_the_one_with_the_most_evidence(diagnosis):
    first, *others = [suspect["evidence"] for suspect in diagnosis["suspects"]]
    assert first > max(others)


def test_the_verdict_fits_a_terminal_and_comes_first(diagnosis):
    document = DiagnosisDocument.model_validate(diagnosis)
    short = printed(diagnosis_text.told(document, UNKNOWN)).splitlines()
    assert len(short) <= 11  # and the line that says what comes next
    assert short[0].rstrip() == " A FORCE IS MISSING: cubic stiffness"
    forces = [s.effect for s in document.suspects if s.plausible and s.kind == "physics"][1:5]
    sensor = next(s.effect for s in document.suspects if s.plausible and s.kind == "sensor")
    missing, either = "A FORCE IS MISSING", "A FORCE IS MISSING, OR A SENSOR IS AT FAULT"
    for rivals, said in (
        (forces[:1], f"{missing}: cubic stiffness or {plain_name(forces[0])}"),
        ([forces[0], sensor], f"{either}: cubic stiffness, {plain_name(forces[0])} or {plain_name(sensor)}"),
        (forces, f"{missing}: cubic stiffness, or one of 4 others"),
    ):
        found = document.model_copy(update={"rivals": rivals})
        assert diagnosis_text.headline(found) == said
        on_the_page = part("verdict", SimpleNamespace(at_floor=False), found).strip()
        assert on_the_page.upper() == f"{said}.".upper()
    text = printed(diagnosis_text.told(document, UNKNOWN, full=True), full=True)
    assert all(len(line) <= 80 for line in (*short, *text.splitlines()))
    assert re.search(r" used +0\.\d+ to \d\.\d+ of 8\.75 s, ", text)
    largest, smallest = (diagnosis["shares"][i]["amplitude"] * 1e3 for i in (0, 1))
    assert f" at {largest:#.3g} mm," in text
    assert f" at {smallest:#.3g} mm," in text
    assert "m²" in text


def test_of_a_suspect_whose_strength_is_not_determined_no_values_are_listed(diagnosis):
    first, *others = diagnosis["suspects"]
    document = DiagnosisDocument.model_validate(
        diagnosis | {"suspects": [first | {"strength_known": False}, *others]}
    )
    table = printed(diagnosis_text.told(document, UNKNOWN)).partition("residual")[2]
    assert "strength not" in table
    assert "k3" not in table
    assert first["strength_known"]


def printed(told, **how):
    stream = io.StringIO()
    show(Console(file=stream, width=80, highlight=False), told, **how)
    return stream.getvalue()


@pytest.mark.slow
def test_a_drifting_sensor_is_named_as_a_sensor(bench, capsys):
    document = told(capsys, "diagnose", DRIFT)
    assert document["verdict"] == "sensor_fault"
    assert document["named"] == ["offset_drift"]
    assert document["suspects"][0]["channel"] == "displacement"
    rate = document["suspects"][0]["parameters"]["rate"]
    assert rate["value"] == pytest.approx(TRUTH[DRIFT.name]["parameters"]["rate"], abs=4 * rate["std"])


def test_nothing_hidden_is_nothing_named(bench, diagnosis, among_few, capsys):
    document = told(capsys, "diagnose", NOTHING)
    assert document["verdict"] == "nothing_missing"
    assert document["named"] == []
    assert document["error"]["chi2"] == pytest.approx(1.0, abs=4 * document["noise_floor"]["chi2_std"])


def test_too_short_a_record_ends_with_8_and_says_so_in_json(bench, capsys, tmp_path):
    rows = DUFFING.read_text().splitlines()
    short = tmp_path / "short.csv"
    short.write_text("\n".join(rows[: 1 + 192 + 120]) + "\n")  # the rest before, and 0.47 s: two cycles
    assert run(["diagnose", str(short), "--json"]) == exits.NOT_IDENTIFIABLE
    out, err = capsys.readouterr()
    document = json.loads(out)
    assert document["verdict"] == "not_enough_data"
    assert set(document["error"]) >= {"force_mse_percent", "motion_percent", "chi2"}
    assert set(document["error"].values()) == {None}
    assert document["explanation"] in err


def test_a_session_given_twice_is_refused(bench, diagnosis, capsys):
    assert run(["diagnose", DUFFING.stem, DUFFING.stem]) == exits.USAGE
    assert "given twice" in capsys.readouterr().err


def test_the_ladder_falls_to_the_floor_and_can_be_gone_back_on(bench, diagnosis, capsys):
    first = told(capsys, "refine", DUFFING.stem, "--reset")
    assert len(first["steps"]) == 1
    second = told(capsys, "refine", DUFFING.stem, "--add", "cubic_stiffness")
    assert second["steps"][0] == first["steps"][0]
    assert [step["added"] for step in second["steps"]] == [None, "cubic_stiffness"]
    for name in ("force_mse_percent", "motion_percent", "chi2"):
        errors = [step["error"][name] for step in second["steps"]]
        assert errors[1] < errors[0] / 3
    assert second["floor"].keys() == {"motion_percent", "chi2"}
    assert all(second["steps"][1]["error"][name] < 1.5 * floor for name, floor in second["floor"].items())
    assert "floor is reached" in second["stopped_because"]
    removed = told(capsys, "refine", DUFFING.stem, "--remove", "coulomb_friction")
    assert removed["steps"][-1]["removed"] == "coulomb_friction"
    assert removed["steps"][-1]["error"]["chi2"] > 100
    back = told(capsys, "refine", DUFFING.stem, "--to", "1")
    assert back["steps"] == second["steps"]
    assert back["steps_above"] == 1
    assert back["stopped_because"] == "gone back to step 1"
    assert (
        told(capsys, "refine", DUFFING.stem, "--to", "2")["stopped_because"] == ""
    )  # there is no step above
    told(capsys, "refine", DUFFING.stem, "--to", "1")
    again = told(capsys, "refine", DUFFING.stem, "--add", "quadratic_damping")
    assert [step["added"] for step in again["steps"]] == [None, "cubic_stiffness", "quadratic_damping"]
    assert again["steps_above"] == 0


def test_the_present_model_is_a_file_that_leaves_nothing_missing(bench, diagnosis, among_few, capsys):
    told(capsys, "refine", DUFFING.stem, "--reset")
    ladder = told(capsys, "refine", DUFFING.stem, "--add", "cubic_stiffness")
    document = told(capsys, "diagnose", DUFFING.stem, "--model", ladder["model_file"])
    assert document["model"]["effects"] == ladder["steps"][-1]["effects"]
    assert document["verdict"] == "nothing_missing"
    chi_square = told(capsys, "compare", DUFFING.stem, "--model", ladder["model_file"])["error"]["chi2"]
    assert chi_square == pytest.approx(
        ladder["steps"][-1]["error"]["chi2"], rel=0.02
    )  # the floor is settled once more


def test_the_ladder_fits_a_terminal_and_ends_with_the_floor(bench, diagnosis, capsys):
    told(capsys, "refine", DUFFING.stem, "--reset")
    told(capsys, "refine", DUFFING.stem, "--add", "cubic_stiffness")
    file = bench / "sessions" / DUFFING.stem / "results" / "ladder.json"
    text = printed(ladder_text.told(KeptLadder.model_validate_json(file.read_bytes()), UNKNOWN))
    lines = text.splitlines()
    assert all(len(line) <= 80 for line in lines)
    table = lines[: next(place for place, line in enumerate(lines) if line.startswith(" changed"))]
    assert "noise alone" in table[-1]
    assert "+ cubic_stiffness" in table[-2]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--add", "magic"], "no effect is called 'magic'"),
        (["--remove", "magic"], "not in the model"),
        (["--add", "coulomb_friction"], "in the model already"),
        (["--to", "99"], "the ladder has steps 0 to"),
        (["--add", "end_stop", "--auto"], "do not go together"),
    ],
)
def test_a_step_that_cannot_be_done_is_refused_and_changes_nothing(
    bench, diagnosis, capsys, arguments, words
):
    before = told(capsys, "refine", DUFFING.stem)
    assert run(["refine", DUFFING.stem, *arguments]) == exits.USAGE
    assert words in capsys.readouterr().err
    assert told(capsys, "refine", DUFFING.stem) == before


def test_a_damaged_ladder_is_told_and_can_be_begun_again(bench, diagnosis, capsys):
    told(capsys, "refine", DUFFING.stem, "--reset")
    file = bench / "sessions" / DUFFING.stem / "results" / "ladder.json"
    file.write_text('{"format": 1, "steps": []}')
    assert run(["refine", DUFFING.stem]) == exits.USAGE
    assert "--reset" in capsys.readouterr().err
    assert len(told(capsys, "refine", DUFFING.stem, "--reset")["steps"]) == 1


def test_numbers_are_written_for_people():
    assert [three_figures(value) for value in (None, float("inf"), 0.0123456, 1.0, 132.4)] == [
        "-",
        "-",
        "0.0123",
        "1.00",
        "132",
    ]
    assert [probability(value) for value in (1e-9, 0.004, 0.5)] == ["<1e-6", "4e-3", "0.50"]
    assert [change(10.0, 1.0), change(1.0, 10.0), change(1.0, 0.9), change(None, 1.0)] == [
        "÷ 10",
        "x 10",
        "-10.0 %",
        "",
    ]
