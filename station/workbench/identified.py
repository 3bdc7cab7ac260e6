"""What both identifications find, as tables of text: the lag, Table 1 of each release and Table 2 of them all."""

from pathlib import Path

from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Problem
from station.operations.identifying import identify_session, kept_options
from station.results.identification_document import IdentificationDocument
from station.results.ladder import KeptLadder, read_ladder
from station.settings import Settings
from station.story.adequacy import Adequacy, judgement
from station.story.pipeline import Progress
from station.text.identification_text import lag_words, methods_table, reasons
from station.text.layout import sentence
from station.text.numbers import typeset
from station.text.table import make_tables
from station.text.table import told as table_told
from station.workbench import view_models
from station.workbench.names import plain


def identified(
    settings: Settings, progress: Progress, folder: Path, others: tuple[Path, ...]
) -> view_models.Identified:
    """Identify a session by both methods, and others for the tables; those that hold too little are named in the notes."""
    progress(f"identifying {folder.name}")
    session = Session.open(folder)
    result, document = identify_session(session, kept_options(session, settings))
    documents, notes = [document], []
    for place, other in enumerate(others):
        progress(f"identifying {other.name}: {place + 1} of {len(others)}")
        try:
            found = _document(settings, other)
        except (NotIdentifiable, Problem) as refusal:
            notes.append(f"{other.name} is left out: {refusal}")
            continue
        if found.record.unit != document.record.unit or _weighed(found) != _weighed(document):
            notes.append(f"{other.name} is left out: its parameters have other units")
        else:
            documents.append(found)
    tables = (methods_table(result), *table_told(make_tables(documents)))
    notes += [f"{label}: {text}" for label, text in reasons(result) if text]
    judged = _judged(result.adequacy, read_ladder(session))
    return view_models.Identified(lag_words(result), tables, tuple(notes), *judged)


def _judged(found: Adequacy | None, ladder: KeptLadder | None) -> tuple[str, bool, str]:
    """Tell whether values may be quoted, and of which model: the current one, with a word on the identified beside it."""
    if found is None:
        return "", False, ""
    words = f"{judgement(found)}. It is {' + '.join(plain(name) for name in found.effects)}"
    if ladder is None or found.doubt or not ladder.top.at_floor or found.quotable:
        return typeset(sentence(words)), found.quotable, ""
    current = f"the refined model leaves {ladder.top.error.words}: quote its values, not those below"
    return typeset(sentence(current)), True, typeset(sentence(words))


def _document(settings: Settings, folder: Path) -> IdentificationDocument:
    session = Session.open(folder)
    return identify_session(session, kept_options(session, settings))[1]


def _weighed(document: IdentificationDocument) -> bool:
    return document.record.mass_kg is not None
