"""`station diagnose`: which effect a model lacks, how sure that is, and what to record next."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from station.commands.options import EFFECTS, FULL, GAIN, MODEL, SESSIONS, VARIES, pass_settings
from station.exits import Answered
from station.output import json_option, print_json, progress
from station.settings import Settings
from station.suggestions import MEASURED_CURVE

if TYPE_CHECKING:
    from station.results.diagnosis_document import DiagnosisDocument

ANOTHER = "ANOTHER_RELEASE"


@click.command("diagnose")
@SESSIONS
@MODEL
@EFFECTS
@GAIN
@click.option(
    "--worth",
    type=click.FloatRange(0.0, 100.0),
    default=0.0,
    metavar="PERCENT",
    help="Name no force that removes less than this share of the motion.",
)
@VARIES
@click.option("--anyway", is_flag=True, help="Even if the sessions look like different benches.")
@FULL
@click.option("--no-viewer", is_flag=True, hidden=True, expose_value=False)  # scripts of before give it
@json_option
@pass_settings
def command(
    settings: Settings,
    sessions: tuple[str, ...],
    model_file: Path | None,
    effects_file: Path | None,
    gain_percent: float | None,
    worth: float,
    varies: tuple[str, ...],
    anyway: bool,
    full: bool,
    as_json: bool,
) -> None:
    """Find out which effect a model lacks.

    SESSION is a session or a data file; several share the physics, but for
    what --varies says was changed between them.
    Without --model it is the current model: the refined one; before any
    `refine` the one that `station identify` found at orders of your choice,
    else the usual one: stiffness, dry and viscous friction.
    """
    from identify.errors import NotIdentifiable
    from identify.model.model import base_model
    from station.operations.diagnosing import check_same_bench, diagnose_sessions, keep
    from station.operations.session_set import declared, open_sessions
    from station.results.diagnosis_document import refused_document

    try:
        opened = open_sessions(sessions, settings, gain_percent, declared([varies]))
    except NotIdentifiable as refusal:
        if as_json:
            names = tuple(Path(session).name for session in sessions)
            print_json(refused_document(names, base_model(), str(refusal)).plain())
        raise Answered(f"not enough data: {refusal}") from refusal
    for name, why in opened.left_out.items():
        progress(f"{name} is left out: {why}")
    check_same_bench(opened, anyway, progress)
    _, document = diagnose_sessions(opened, model_file, effects_file, progress, worth=worth)
    keep(opened, document)
    if as_json:
        print_json(document.plain())
    else:
        from station.story.preparation import weighing_of
        from station.text.diagnosis_text import told
        from station.text.layout import tell

        weighing = weighing_of(opened.sessions[0], settings, opened.decays[0].window.unit)
        folders = [session.folder for session in opened.sessions]
        tell(told(document, weighing, full=full), *next_step(folders, document), full=full)
    if document.verdict == "not_enough_data":
        raise Answered(f"not enough data: {document.explanation}")


def next_step(folders: "list[Path]", document: "DiagnosisDocument") -> tuple[str | Path, ...]:
    """Choose the command that comes next: where nothing is decided, to diagnose this together with another release."""
    if document.named and document.verdict in ("missing_effect", "sensor_fault"):
        return ("refine", folders[0], "--add", document.named[0])
    if document.verdict == "unknown_effect" and document.shape is not None and document.shape.coordinates:
        return ("refine", folders[0], "--add", MEASURED_CURVE)
    if document.verdict == "nothing_missing":
        return ("report", folders[0])
    if document.of_sessions:
        return ("diagnose", folders[0])
    return () if document.verdict == "not_enough_data" else ("diagnose", *folders, ANOTHER)
