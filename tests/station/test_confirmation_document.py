"""What is confirmed, as data and in words: what every part is predicted to, in percent of the motion."""

import io
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

from identify.curves.confirmation import Confirmation, ConfirmedEffect
from identify.curves.held_out import HeldOut, MotionError
from identify.diagnosis.explain_prediction import explain_unconfirmed
from identify.effects.library import find_effect
from identify.evidence import Evidence
from identify.judging.verdict import headline_of
from identify.model.model import Term, base_model
from station.report.loop import suspects
from station.results.confirmation_document import confirmation_document
from station.results.diagnosis_document import (
    DecidedDocument,
    DiagnosisDocument,
    ShapeDocument,
    refused_document,
)
from station.story.engineering_values import UNKNOWN
from station.text.diagnosis_text import next_command, predictions, residuals, told
from station.text.layout import show

NAMES = ("first", "second", "third")
NONE = np.zeros(0)


def held(*errors: tuple[float, float], one_record: bool = False) -> HeldOut:
    """Return errors of the envelope and of the phase, a pair a part."""
    parts = tuple(MotionError(envelope, phase) for envelope, phase in errors)
    return HeldOut(NONE, parts, one_record)


def confirmation(*, one_record: bool = False, effects: bool = True) -> Confirmation:
    usual = held((3.0, 4.0), (0.0, 6.0), (8.0, 6.0))
    found = held((0.0, 1.0), (0.0, 9.0), (0.0, 2.0)) if effects else usual
    if one_record:
        usual = held((3.0, 4.0), (0.0, 6.0), one_record=True)
        found = held((0.0, 1.0), (0.0, 2.0), one_record=True)
    drag_nats = {"quadratic_damping": 12.5, "cubic_damping": 11.0}
    evidence = Evidence(drag_nats, "named", ("quadratic_damping", "cubic_damping"), "loss")
    drag = ConfirmedEffect(
        Term(find_effect("quadratic_damping")), 0.3, "loss", 6.0, 2.0, 2, 3, evidence, evidence.names[1:]
    )
    alike = Evidence({}, "may drift", ("cubic_stiffness", "time_varying_stiffness"), "frequency")
    effects_found, releases = (drag,) if effects else (), (0,) if one_record else (0, 1, 2)
    return Confirmation(effects_found, usual, found, one_record, (evidence, alike), releases=releases)


def suspect(effect: str, confirmed: bool | None, **others: object) -> dict[str, object]:
    numbers = {"error_after": 366.2, "motion_percent": 1.16, "evidence": 143.0}
    texts = {"title": effect, "kind": "physics", "channel": None, "model": None}
    known = {"parameters": {"mu_2": {"value": 0.3, "std": 0.01, "unit": "1/m"}}, "confusable_with": []}
    named = {"effect": effect, "confirmed": confirmed, "plausible": True, "claimed": bool(confirmed)}
    return numbers | texts | known | named | others


def document(found: Confirmation, sessions: tuple[str, ...] = NAMES) -> DiagnosisDocument:
    """Return a diagnosis that names drag, confirmed so."""
    error = {
        "force_mse_percent": 11.8,
        "motion_percent": 57.3,
        "chi2": 679236.0,
        "horizon_s": 4.8,
        "chi2_std": 0.05,
    }
    rivals = ["cubic_damping"] if found.effects else []
    return DiagnosisDocument.model_validate(
        refused_document(sessions, base_model(), "").plain()
        | {"verdict": "missing_effect" if found.effects else "unconfirmed", "error": error}
        | {"named": list(found.names), "confirmed": list(found.names), "rivals": rivals}
        | {"confirmation": confirmation_document(found, sessions).plain()}
        | {"noise_floor": {"chi2_std": 0.05, "channels": {}}}
        | {"error_with_named": {"motion_percent": 1.16, "chi2": 366.0}}
        | {
            "suspects": [
                suspect("quadratic_damping", bool(found.effects)),
                suspect("offset_drift", None),
                suspect("time_varying_stiffness", False),
                suspect("cubic_damping", False),
            ][: 4 if found.effects else 1]
        }
    )


def printed(found: DiagnosisDocument) -> str:
    out = io.StringIO()
    show(Console(file=out, width=80), told(found, UNKNOWN))
    return out.getvalue()


def test_every_release_that_was_left_out_has_its_errors_under_its_name():
    kept = confirmation_document(confirmation(), NAMES)
    assert (kept.one_record, kept.parts, kept.better) == (False, 3, 2)
    # 3 and 4 % in quadrature; the rms of 5, 6 and 10.
    assert [one.motion_percent for one in kept.usual.by_part] == pytest.approx([5.0, 6.0, 10.0])
    assert kept.usual.motion_percent == pytest.approx(7.3258, abs=1e-4)
    assert [one.part for one in kept.found.by_part] == list(NAMES)
    (effect,) = kept.effects
    assert (effect.name, effect.explains, effect.before_percent, effect.after_percent) == (
        "quadratic_damping",
        "loss",
        6.0,
        2.0,
    )
    assert effect.rivals == ["cubic_damping"]
    assert kept.undecided == {"frequency": ["cubic_stiffness", "time_varying_stiffness"]}


def test_the_parts_of_one_record_are_its_large_and_its_small_amplitudes():
    kept = confirmation_document(confirmation(one_record=True), ("first",))
    assert [one.part for one in kept.found.by_part] == ["large amplitudes", "small amplitudes"]
    three = confirmation()
    kept = confirmation_document(replace(three, one_record=True, releases=(0,)), ("first",))
    parts = [f"{size} amplitudes" for size in ("large", "middle", "small")]
    assert [one.part for one in kept.found.by_part] == parts


def test_releases_with_a_curve_keep_the_names_of_their_sessions() -> None:
    found = replace(confirmation(), releases=(0, 2, 3))
    parts = confirmation_document(found, ("first", "short", "third", "fourth")).found.by_part
    assert [part.part for part in parts] == ["first", "third", "fourth"]
    alone = replace(confirmation(one_record=True), releases=(1,))
    parts = confirmation_document(alone, ("short", "long")).found.by_part
    assert [part.part for part in parts] == ["long, large amplitudes", "long, small amplitudes"]


def test_a_document_that_an_older_version_wrote_is_still_read():
    old = document(confirmation()).plain()
    for name in ("confirmed", "confirmation", "final"):
        del old[name]
    for entry in old["suspects"]:
        for name in ("confirmed", "rivals", "motion_percent"):
            del entry[name]
    read = DiagnosisDocument.model_validate(old)
    assert (read.confirmed, read.confirmation) == ([], None)
    assert read.suspects[0].confirmed is None
    assert predictions(read) == ()
    assert "times noise" in printed(read)
    assert "decisive" not in printed(read)


def test_what_is_predicted_of_every_part_is_told_in_percent_of_the_motion():
    found = document(confirmation())
    (parts,) = predictions(found)
    assert [row[:2] for row in parts.rows[:3]] == [
        ("first", "5.00 to 1.00"), ("second", "6.00 to 9.00"), ("third", "10.0 to 2.00")
    ]  # fmt: skip
    assert parts.rows[3] == ("all, rms", "7.33 to 5.35", "5.42 to 5.35", "4.93 to 0.00")
    alone = document(confirmation(one_record=True), ("first",))
    assert predictions(alone)[0].rows[-1][:2] == ("all but the large amplitudes", "6.00 to 2.00")


def test_the_terminal_says_percent_of_the_motion_and_times_the_noise_and_what_each_suspect_predicts():
    text = printed(document(confirmation()))
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80
    assert re.search(r"the usual model +57\.3 +824", text)  # the root of chi-square
    rows = {line.split()[1]: line for line in text.splitlines() if "1.16" in line}
    assert re.search(r" 1\.16 +19\.1 ", rows["quadratic_damping"])
    assert "2 of 3" in rows["quadratic_damping"]
    assert "nearly" in rows["cubic_damping"]
    assert "undecided" in rows["time_varying_stiffness"]
    assert " - " in rows["offset_drift"]


def test_a_misfit_that_nothing_predicts_is_said_with_its_size_and_no_name():
    found = document(confirmation(effects=False))
    text = printed(found)
    assert text.strip().startswith("SOMETHING IS MISSING, AND NO EFFECT IS SURE ENOUGH FOR A NAME")
    assert headline_of("unconfirmed", undecided=False) == "No known effect predicts the residual"
    (parts,) = predictions(found)
    assert [row[:2] for row in parts.rows] == [
        ("first", "5.00"), ("second", "6.00"), ("third", "10.0"), ("all, rms", "7.33")
    ]  # fmt: skip


@pytest.mark.parametrize("effects", [True, False])
def test_evidence_that_alone_would_do_is_not_said_to_suffice_where_the_verdict_names_nothing(
    effects: bool,
) -> None:
    nats = {"cubic_stiffness": 12.0}
    weighed = DecidedDocument(
        verdict="named", explains="", nats=nats, names=["cubic_stiffness"], unnamed=1.0, beside=0.0
    )
    said = told(document(confirmation(effects=effects)).model_copy(update={"decided": [weighed]}), UNKNOWN)
    (caption,) = (part.caption for part in said.more if getattr(part, "head", ("",))[0] == "law")
    assert caption.endswith("suffices for a name") == effects


def test_the_report_has_a_table_of_what_was_predicted():
    without_pictures = document(confirmation()).model_copy(update={"suspects": []})
    parts = suspects(
        SimpleNamespace(
            diagnosis=without_pictures, maps=(), curves=None, compared=None, left_out={}, weighing=UNKNOWN
        )
    )
    table = next(p for p in parts if p.kind == "table" and p.head[0] == "left out")
    assert table.rows[0] == ("first", "5.00 to 1.00", "4.00 to 1.00", "3.00 to 0.00")
    assert table.rows[-1][0] == "all, rms"


def test_what_is_not_distinguishable_is_named_together_with_what_would_tell():
    told = explain_unconfirmed(confirmation(effects=False), (), 2.0)
    assert told.startswith("The frequency changes: ")
    assert "would explain it, and these records cannot tell which." in told
    assert "No effect of the library" in explain_unconfirmed(
        replace(confirmation(effects=False), asked=()), (), 2.0
    )


def test_a_confirmed_effect_has_its_evidence():
    (effect,) = confirmation_document(confirmation(), NAMES).effects
    assert (effect.nats, effect.rivals) == (12.5, ["cubic_damping"])


def test_what_the_whole_motion_names_against_the_predictions_has_no_row_that_says_no():
    named = document(confirmation())
    other = named.model_copy(update={"named": [named.suspects[-1].effect], "confirmed": []})
    assert named.by_prediction
    assert named.suspects[-1].confirmed is False
    assert not other.by_prediction
    assert "predicts" not in residuals(other).head
    assert predictions(other) == ()


def test_what_comes_next_adds_all_that_is_named_and_a_measured_curve_once():
    folder = Path("one")
    two = document(confirmation()).model_copy(update={"named": ["dahl_friction", "quadratic_damping"]})
    assert next_command(two, [folder]) == (
        "refine",
        folder,
        "--add",
        "dahl_friction",
        "--add",
        "quadratic_damping",
    )
    shape = ShapeDocument(explained=1.0, coordinates=["displacement"], curves=[])
    rest = two.model_copy(update={"named": [], "verdict": "unknown_effect", "shape": shape})
    assert next_command(rest, [folder])[-1] == "measured_curve"
    effects = [*rest.model.effects, "measured_curve"]
    hardly = shape.model_copy(update={"explained": 0.4})
    assert next_command(rest.model_copy(update={"shape": hardly}), [folder])[-1] == "ANOTHER_RELEASE"
    again = rest.model_copy(update={"model": rest.model.model_copy(update={"effects": effects})})
    assert next_command(again, [folder]) == ("diagnose", folder, "ANOTHER_RELEASE")
    assert again.is_of(effects)
    assert not rest.is_of(effects)
