"""`station diagnose`: find out which effect a model lacks."""

from pathlib import Path

import click

from station.commands.options import EFFECTS, FULL, MODEL, SESSIONS, VARIES, declared, option
from station.exits import Answered
from station.output import asked_for_json, print_json, progress
from station.settings import Settings


@declared("diagnose")
@click.option("--no-viewer", is_flag=True, hidden=True, expose_value=False)
def command(
    settings: Settings,
    sessions: tuple[str, ...] = SESSIONS,
    model_file: Path | None = MODEL,
    effects_file: Path | None = EFFECTS,
    worth: float = option(
        "Name no force that removes less than this share of the motion.",
        type=click.FloatRange(0.0, 100.0),
        default=0.0,
        metavar="PERCENT",
    ),
    varies: tuple[str, ...] = VARIES,
    anyway: bool = option("Diagnose together even sessions that look like different benches."),
    full: bool = FULL,
) -> None:
    """Find out which effect a model lacks.

    SESSION is a session or a data file; several share their physics, except
    what --varies names as changed between them.
    Without --model the current model is diagnosed: the refined one; before any
    `refine` the one that `station identify` found at orders of your choice;
    else the usual one (stiffness, dry and viscous friction).
    """
    from identify.errors import NotIdentifiable
    from identify.model.model import base_model
    from station.operations.diagnosing import check_same_bench, diagnose_sessions
    from station.operations.session_set import by_reason, declared, open_sessions
    from station.results.diagnosis_document import refused_document
    from station.story.preparation import weighing_of
    from station.text.diagnosis_text import next_command, told
    from station.text.layout import answer

    try:
        opened = open_sessions(sessions, settings, declared([varies]))
    except NotIdentifiable as refusal:
        if asked_for_json():
            names = tuple(Path(session).name for session in sessions)
            print_json(refused_document(names, base_model(), str(refusal)).plain())
        raise Answered(f"not enough data: {refusal}") from refusal
    for reason in by_reason(opened.left_out):
        progress(f"left out: {reason}")
    check_same_bench(opened, anyway, progress)
    _, document = diagnose_sessions(opened, model_file, effects_file, progress, worth=worth)
    weighing = weighing_of(opened.sessions[0], settings, opened.decays[0].window.unit)
    words = told(document, weighing, full=full)
    folders = [session.folder for session in opened.sessions]
    answer(document.plain(), words, *next_command(document, folders), full=full)
    if document.verdict == "not_enough_data":
        raise Answered("not enough data to distinguish effects")
