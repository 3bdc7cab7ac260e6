"""Diagnose one or several sessions and keep what was found."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.errors import NotIdentifiable
from identify.fitting.leave_one_out import leave_one_out
from identify.model.model import base_model
from station.exits import NOT_IDENTIFIABLE, Problem
from station.operations.session_set import SessionSet, chosen_model, open_sessions, whole_library
from station.output import finite, print_json
from station.results.diagnosis_document import diagnosis_document, refused_document
from station.settings import Settings

RESULT = "diagnosis.json"


class NotEnoughData(Problem):
    """The record holds too little to diagnose; the document was printed already."""

    exit_code = NOT_IDENTIFIABLE
    reported = True


def open_or_refuse(
    arguments: tuple[str, ...], settings: Settings, gain_percent: float | None, as_json: bool
) -> SessionSet:
    """Open the sessions; where one holds too little, print the verdict as JSON if asked and raise NotEnoughData."""
    try:
        return open_sessions(arguments, settings, gain_percent)
    except NotIdentifiable as refusal:
        if as_json:
            names = tuple(Path(argument).name for argument in arguments)
            print_json(refused_document(names, base_model(), str(refusal)))
        raise NotEnoughData(f"not enough data: {refusal}") from refusal


def diagnose_sessions(
    sessions: SessionSet,
    model_file: Path | None = None,
    effects_file: Path | None = None,
    tell: Callable[[str], None] = lambda text: None,
) -> tuple[Diagnosis, dict[str, Any]]:
    """Diagnose sessions that are ready; return both forms."""
    library = whole_library(effects_file)
    model, known, expressions = chosen_model(model_file, sessions.settings, library)
    tell(f"trying {len(library) - len(model.terms)} effects on {', '.join(sessions.names)}")
    found = diagnose(sessions.settings, model, library=library, known=known)
    left_out = None
    if len(sessions.settings) > 1:
        tell("leaving one session out at a time")
        left_out = leave_one_out(found.final)
    return found, diagnosis_document(sessions.names, found, expressions, left_out)


def keep(sessions: SessionSet, document: dict[str, Any]) -> None:
    """Write results/diagnosis.json into each session."""
    text = json.dumps(finite(document), indent=2, ensure_ascii=False) + "\n"
    for session in sessions.sessions:
        session.write_result(RESULT, text)


def refuse_if_too_little(document: dict[str, Any]) -> None:
    """Raise NotEnoughData when that is the verdict."""
    if document["verdict"] == "not_enough_data":
        raise NotEnoughData(f"not enough data: {document['explanation']}")
