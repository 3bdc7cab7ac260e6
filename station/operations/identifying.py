"""Identify a session and keep what was found in it."""

from dataclasses import replace
from typing import Any

from daq.manifest import known_manifest
from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Answered, UsageProblem
from station.operations.current_model import kept_identification
from station.results.documents import keep_document
from station.results.identification_document import NAME, identification_document
from station.settings import Settings
from station.story.adequacy import adequacy, recording_doubt
from station.story.pipeline import Identification, Progress, identify, silent
from station.story.preparation import Options, locate, options_for, prepare_recording, with_floor


def identify_session(
    session: Session, settings: Settings, progress: Progress = silent, options: Options | None = None
) -> tuple[Identification, dict[str, Any]]:
    """Identify a session and write results/identification.json; return the identification and its document.

    Without `options` at the orders that were chosen before, else at those of the settings. The model that was found is
    judged on the same record, so that nobody quotes what does not explain it.
    """
    recording, options = session.recording(), options or kept_options(session, settings)
    progress("identifying by both methods")
    found = locate(recording, options)
    result = identify(recording, options, found)
    sealed = known_manifest(session.folder)
    try:
        progress("fitting the identified model")
        prepared = with_floor(prepare_recording(recording, options, found=found))
        if result.methods:
            judged = adequacy(prepared, result.methods, recording_doubt(sealed))
            result = replace(result, adequacy=judged)
    except NotIdentifiable as refusal:
        result = replace(result, refusals=result.refusals | {"adequacy": str(refusal)})
    document = identification_document(session.folder.name, result, options)
    keep_document(session, NAME, document, progress)
    return result, document


def kept_options(session: Session, settings: Settings) -> Options:
    """Return the options with the orders that the operator chose when the session was identified, where they did."""
    options = options_for(session, settings)
    try:
        kept = kept_identification(session)
    except UsageProblem:  # altered: it is made again
        return options
    if kept is None or not kept.chosen:
        return options
    return replace(options, max_order=kept.max_order, stiffness_orders=kept.stiffness_orders)


def identified(session: Session, settings: Settings) -> Identification:
    """Identify a session at the orders that were chosen; NotIdentifiable where neither method finds anything."""
    result, _ = identify_session(session, settings)
    if not result.methods:
        raise NotIdentifiable("nothing identified")
    return result


def refuse_if_nothing(result: Identification) -> None:
    """Raise Answered when both methods refused: with the reason of the first, as all are printed before."""
    if not result.methods:
        raise Answered(f"nothing could be identified: {result.refusals['wavelet']}")
