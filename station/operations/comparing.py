"""Compare a session with a model, and keep what was found in it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from daq.session import Session
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.beginning import (
    USUAL_MODEL,
    Beginning,
    beginning,
    identified_effects,
    model_of,
)
from station.operations.identifying import identify_session, kept_options
from station.operations.record_floor import prepare_with_floor
from station.results.comparison_document import NAME, ComparisonDocument, comparison_document
from station.results.documents import write_document
from station.settings import Settings
from station.story.compared import Compared
from station.story.pipeline import compare
from station.story.preparation import options_for

VIEW = "comparison.rrd"


def identified_model(session: Session, settings: Settings) -> Beginning:
    """Return the model that was identified in a session, orders included; it is identified first where it was not yet.

    The usual model where nothing could be identified.
    """
    names = identified_effects(session)
    if not names:
        identify_session(session, kept_options(session, settings))
        names = identified_effects(session)
    if not names:
        return Beginning(base_model(), USUAL_MODEL)
    model = model_of(names)
    usual = set(names) == set(base_model().names)
    return Beginning(
        model, "the identified model, which is the usual one" if usual else "the identified model"
    )


def compare_session(
    session: Session,
    settings: Settings,
    model: Path | Beginning | None = None,
    *,
    mass: float | None = None,
    prepared: PreparedDecay | None = None,
) -> tuple[Compared, ComparisonDocument]:
    """Compare a session with a model (or its file; else the one that it begins with); write results/comparison.json.

    `mass` (kg) replaces the session's; `prepared` is its release, where it was prepared before. Returns the comparison
    and its document.
    """
    prepared = prepared or prepare_with_floor(session, settings, mass=mass)
    begun = model if isinstance(model, Beginning) else beginning((session,), (prepared,), model)
    weight = options_for(session, settings, mass).mass
    compared = compare(
        session.folder.name, prepared, begun.model, begun.known, mass=weight, words=begun.words
    )
    document = comparison_document(compared)
    write_document(session, NAME, document)
    return compared, document


def write_view(session: Session, compared: Compared) -> Path:
    """Write the Compare tab of the viewer into the session's results; return the file."""
    from station.views import compare as tab

    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        tab.write_file(file, compared)
        return session.write_result(VIEW, file.read_bytes())
