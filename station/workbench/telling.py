"""What the tabs of the page show: words, tables and pictures as in the commands, Rerun's viewer, the way to the report."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from urllib.parse import quote

from daq.errors import StationError
from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Problem, UsageProblem
from station.operations.diagnosing import compare_session
from station.operations.identifying import identify_session
from station.operations.session_set import kept_curves
from station.operations.validating import validate_sessions
from station.operations.viewer_tabs import write_view
from station.operations.workers import Say
from station.report.loop import curves_of, where_it_fails
from station.report.write import write_report
from station.results.ladder import read_ladder
from station.settings import Settings
from station.text import comparison_text, identification_text, table, validation_text
from station.text.content import Figure, Paragraph, Told, facts
from station.text.layout import sentence
from station.views.figure import inked
from station.views.identification_figures import record
from station.views.palette import PAGE
from station.views.viewer import unpack
from station.workbench.opened_session import kept_diagnosis, open_session
from station.workbench.parts import part


def tell(settings: Settings, say: Say, folder: Path, what: Callable[..., Told | str], *arguments: Any) -> str:
    """Write what one of the functions below tells as HTML; what is HTML already stays as it is."""
    found = what(settings, say, folder, *arguments)
    return found if isinstance(found, str) else part("told", found)


def compared(settings: Settings, say: Say, folder: Path, dark: bool) -> Told:
    """Tell where the present model fails, under the curves of the diagnosis that a session keeps."""
    say("comparing with the measurement")
    refinement, look = open_session(settings, folder).refinement, PAGE[dark]
    found, _ = compare_session(refinement.session, settings, prepared=refinement.prepared, tell=say)
    words, document, kept = comparison_text.told(found), kept_diagnosis(refinement.session), None
    if document is not None:
        with suppress(UsageProblem):  # an effect of a file that is not at hand
            kept = kept_curves(refinement, document, settings)
    with inked(look):
        parts = where_it_fails(found, look)
        if kept is not None:
            parts = (curves_of(kept, look), *parts)
    return replace(words, brief=parts, more=())


def recorded(settings: Settings, say: Say, folder: Path, dark: bool) -> Told:
    """Show a record that allows no analysis as it stands; nothing where it cannot be read."""
    look, parts = PAGE[dark], tuple[Figure, ...]()
    with suppress(StationError), inked(look):
        recording = Session.open(folder).recording()
        if recording.samples.shape[1] > 1:
            parts = (Figure("The channels as they were recorded.", record(recording, look=look)),)
    return Told("", "", parts)


def identified(settings: Settings, say: Say, folder: Path, others: tuple[Path, ...]) -> Told:
    """Tell what both methods find in a session, beside others in the tables; those that hold too little say why."""
    say(f"identifying {folder.name}")
    session = Session.open(folder)
    result, _ = identify_session(session, settings, say)
    results, left_out, own = [(folder.name, result)], [], result.decay
    for place, other in enumerate(others):
        say(f"identifying {other.name}: {place + 1} of {len(others)}")
        try:
            found, _ = identify_session(Session.open(other), settings, say)
        except (NotIdentifiable, Problem) as refusal:
            left_out.append((other.name, f"left out: {refusal}"))
            continue
        if found.decay.unit != own.unit or (found.decay.mass is None) != (own.mass is None):
            left_out.append((other.name, "left out: its parameters have other units"))
        else:
            results.append((other.name, found))
    words, ladder, adequacy = (
        identification_text.told(folder.name, result),
        read_ladder(session),
        result.adequacy,
    )
    tables = table.in_pieces(table.make_tables(results)) if len(results) > 1 else []
    parts = (*words.brief, *tables, *facts(left_out))
    if ladder is not None and ladder.top.at_floor and adequacy and not (adequacy.doubt or adequacy.quotable):
        current = f"the refined model leaves {ladder.top.error.words}: quote its values, not those below"
        return Told(sentence(current), "good", (Paragraph(words.headline), *parts))
    return replace(words, brief=parts)


def validated(settings: Settings, say: Say, folder: Path, others: tuple[Path, ...]) -> Told:
    """Predict other sessions by the present model, and tell how well."""
    chosen = tuple(str(other) for other in others)
    return validation_text.told(validate_sessions(str(folder), chosen, settings, progress=say))


def viewer(settings: Settings, say: Say, folder: Path, temporary: Path, host: str, dark: bool) -> str:
    """Write the recording that `station view` writes, and the viewer's own files; return the viewer as HTML."""
    session = Session.open(folder)
    result, _ = identify_session(session, settings, say)
    say("writing the recording")
    file = write_view(session, result, settings, dark=dark)
    if not (temporary / "index.html").is_file():
        unpack(temporary)
    place = f"viewer/recording/{file.stat().st_mtime_ns}/{quote(folder.name, safe='')}.rrd"  # no browser keeps an old one
    recording, theme = quote(f"http://{host}/{place}", safe=""), "dark" if dark else "light"
    return part("viewer", f"/viewer/index.html?url={recording}&hide_welcome_screen=1&theme={theme}")


def report(settings: Settings, say: Say, folder: Path) -> str:
    """Write the report of a session; return the way to it as HTML."""
    say("writing the report")
    write_report(Session.open(folder), settings=settings, progress=say)
    return way_to_report(folder.name)


def way_to_report(key: str) -> str:
    """Write the way to the report of a session as HTML."""
    return part("report", f"/report/{quote(key, safe='')}")
