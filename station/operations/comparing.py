"""Compare a session with a model, and keep what was found in it."""

from pathlib import Path
from typing import Any

from daq.session import Session
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.current_model import current_model
from station.output import progress
from station.own_effects import whole_library
from station.results.comparison_document import NAME, comparison_document
from station.results.documents import keep_document
from station.settings import Settings
from station.story.compared import Compared
from station.story.pipeline import Progress, compare
from station.story.preparation import prepare_session


def compare_session(
    session: Session,
    settings: Settings,
    model_file: Path | None = None,
    effects_file: Path | None = None,
    *,
    prepared: PreparedDecay | None = None,
    tell: Progress = progress,
) -> tuple[Compared, dict[str, Any]]:
    """Compare a session with its current model, or that of a file; write results/comparison.json.

    `prepared` is its release, where it was prepared before. `tell` gets a sentence where the session may not be written.
    Returns the comparison and its document.
    """
    if prepared is None:
        prepared = prepare_session(session, settings)
    current = current_model((session,), model_file, whole_library(effects_file))
    compared = compare(session.folder.name, prepared, current)
    document = comparison_document(compared)
    keep_document(session, NAME, document, tell)
    return compared, document
