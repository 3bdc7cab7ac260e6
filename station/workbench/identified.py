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
from station.text.layout import sentence
from station.text.numbers import scale, typeset, typeset_error, typeset_symbol, typeset_unit
from station.text.table import Cell, Tables, make_tables
from station.text.terminal import rows, uncorrected
from station.workbench import view_models
from station.workbench.names import plain

NONE = "–"


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
    for method, label in (("wavelet", "Wavelet"), ("restoring_force", "Restoring force")):
        found_by = getattr(result, method)
        notes.append(f"{label}: {result.refusals[method] if found_by is None else found_by.reason}.")
    warning = uncorrected(result)
    methods = [
        (typeset(name), typeset(unit), *(typeset(c) for c in cells)) for name, unit, *cells in rows(result)
    ]
    tables = [
        view_models.TextTable(
            "This release by both methods", ("", "unit", "wavelet", "restoring force"), tuple(methods)
        )
    ]
    tables += _tables(make_tables(documents))
    return view_models.Identified(
        _lag(document),
        tuple(tables),
        (*notes, *([f"Without {typeset(warning)}."] if warning else [])),
        *_judged(result.adequacy, read_ladder(session)),
    )


def _judged(found: Adequacy | None, ladder: KeptLadder | None) -> tuple[str, bool, str]:
    """Return whether values may be quoted, and of which model: the current one, with a word on the identified beside it."""
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


def _lag(document: IdentificationDocument) -> tuple[str, str]:
    found = document.alignment
    if found is None:
        return NONE, document.refusals.get("alignment", "The lag was not sought: it needs two channels.")
    lag = found.lag_s
    late = "late" if (lag.value or 0.0) >= 0 else "early"
    value = f"{typeset_error(abs(lag.value or 0.0) * 1e3, (lag.std or 0.0) * 1e3)} ms"
    gain = typeset_error(found.gain.value, found.gain.std)
    return (
        value,
        f"by which the displacement is {late}, corrected; gain between the channels {gain}. {found.caution}".strip(),
    )


def _tables(tables: Tables) -> list[view_models.TextTable]:
    head = ("release", "amplitude", *(_column(*column) for column in tables.columns))
    lines = []
    for row in tables.rows:
        amplitude = NONE
        if row.amplitude is not None:
            factor, unit = scale("displacement", row.unit)
            amplitude = f"{row.amplitude * factor:.4g} {typeset(unit)}"
        lines.append((row.session, amplitude, *(_cell(cell) for cell in row.cells)))
    first = view_models.TextTable("Table 1. Identified parameters (± one standard error)", head, tuple(lines))
    if len(tables.rows) < 2:
        return [first]
    names = tuple(f"{typeset_symbol(name)} [{typeset_unit(unit)}]" for name, _, unit in tables.columns[::2])
    means = tuple((method, *(_cell(cell) for cell in cells)) for method, cells in tables.summary)
    caption = f"Table 2. Mean and standard deviation over {len(tables.rows)} releases"
    return [first, view_models.TextTable(caption, ("", *names), means)]


def _column(name: str, method: str, unit: str) -> str:
    return f"{typeset_symbol(name)} ({method}) [{typeset_unit(unit)}]"


def _cell(cell: Cell | None) -> str:
    return NONE if cell is None else typeset_error(cell.value, cell.std)
