"""Compare a session with a model, and keep what was found in it."""

from pathlib import Path
from tempfile import TemporaryDirectory

from daq.session import Session
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.session_set import chosen_model
from station.results.comparison_document import NAME, ComparisonDocument, comparison_document
from station.results.documents import write_document
from station.settings import Settings
from station.story.compared import Compared
from station.story.pipeline import compare
from station.story.preparation import options_for, prepare_session

VIEW = "comparison.rrd"


def compare_session(
    session: Session,
    settings: Settings,
    model: Path | None = None,
    *,
    mass: float | None = None,
    prepared: PreparedDecay | None = None,
) -> tuple[Compared, ComparisonDocument]:
    """Compare a session with a model (its file; else the usual one); write results/comparison.json.

    `mass` (kg) replaces the session's; `prepared` is its release, where it was prepared before. Returns the comparison
    and its document.
    """
    prepared = prepared or prepare_session(session, settings, mass=mass)
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
