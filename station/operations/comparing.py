"""Compare a session with a model, and keep what was found in it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from daq.session import Session
from identify.effects.library import find_effect
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.identifying import identify_session
from station.operations.session_set import chosen_model
from station.results.comparison_document import NAME, ComparisonDocument, comparison_document
from station.results.documents import read_document, write_document
from station.results.identification_document import NAME as IDENTIFICATION
from station.results.identification_document import IdentificationDocument
from station.settings import Settings
from station.story.compared import Compared
from station.story.pipeline import compare
from station.story.preparation import options_for, prepare_session

VIEW = "comparison.rrd"


def own_model(session: Session, settings: Settings) -> Model:
    """Return the model that was identified in a session, orders included; it is identified first where it was not yet.

    The usual model where nothing could be identified.
    """
    kept = read_document(session, IDENTIFICATION, IdentificationDocument, "identify it again")
    if kept is None or kept.adequacy is None:
        _, kept = identify_session(session, options_for(session, settings))
    if kept.adequacy is None:
        return base_model()
    return Model(tuple(Term(find_effect(name)) for name in kept.adequacy.effects))


def compare_session(
    session: Session,
    settings: Settings,
    model: Path | Model | None = None,
    *,
    mass: float | None = None,
    prepared: PreparedDecay | None = None,
) -> tuple[Compared, ComparisonDocument]:
    """Compare a session with a model (or its file; else the usual one); write results/comparison.json.

    `mass` (kg) replaces the session's; `prepared` is its release, where it was prepared before. Returns the comparison
    and its document.
    """
    prepared = prepared or prepare_session(session, settings, mass=mass)
    if isinstance(model, Model):
        chosen, known = model, None
    else:
        chosen, known, _ = chosen_model(model, (prepared,))
    weight = options_for(session, settings, mass).mass
    compared = compare(session.folder.name, prepared, chosen, known, mass=weight)
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
