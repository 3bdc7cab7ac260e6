"""The tabs Compare, Suspects, Curves and Ladder, for the session's recording and for a viewer that is open."""

import time
from typing import TYPE_CHECKING

from daq.session import Session
from identify.diagnosis.diagnose import Diagnosis
from station.exits import UsageProblem
from station.operations.comparing import compare_session
from station.operations.refining import Refinement, open_refinement, step_again
from station.operations.session_curves import curves_as_measured, kept_curves
from station.operations.session_set import SessionSet
from station.output import progress
from station.results import comparison_document, diagnosis_document
from station.results.curves import NamedCurves, diagnosed_curves
from station.results.diagnosis_document import DiagnosisDocument, read_diagnosis
from station.results.diagnosis_fits import DiagnosisFits, fits_of, refitted
from station.results.ladder import LADDER
from station.settings import Settings

if TYPE_CHECKING:
    from station.views.tab import Tab


def suspects_tab(fits: DiagnosisFits) -> "Tab":
    """Return the Suspects tab of a diagnosis."""
    from station.views import suspects
    from station.views.tab import Tab

    return Tab(suspects.NAME, lambda stream: suspects.write(stream, fits), lambda: suspects.tab(fits))


def curves_tab(shown: NamedCurves) -> "Tab":
    """Return the Curves tab."""
    from station.views import curves
    from station.views.tab import Tab

    return Tab(curves.NAME, lambda stream: curves.write(stream, shown), curves.tab)


def kept_suspects_tab(refinement: Refinement) -> "Tab | None":
    """Return the Suspects tab of the diagnosis that a session keeps; None when it keeps none that can be read."""
    try:
        document = read_diagnosis(refinement.session)
        fits = None if document is None else refitted(document, refinement.prepared, refinement.library)
    except UsageProblem as problem:
        progress(f"the tab Suspects is left out: {problem}")
        return None
    return None if fits is None else suspects_tab(fits)


def ladder_tab(refinement: Refinement, root: str = "/ladder") -> "Tab":
    """Return the Ladder tab of a session; each step's fit is found again from its values."""
    from station.views import ladder
    from station.views.tab import Tab

    kept = refinement.ladder
    fits = tuple(step_again(refinement, step).fit for step in kept.steps[: kept.present + 1])
    fitted = ladder.FittedLadder(refinement.session.folder.name, kept, fits)
    return Tab(
        ladder.NAME, lambda stream: ladder.write(stream, fitted, root), lambda: ladder.tab(fitted, root)
    )


def kept_tabs(refinement: Refinement) -> tuple["Tab", ...]:
    """Return the tabs of what a session's results hold: Suspects after a diagnosis, Ladder after a refinement."""
    suspects = kept_suspects_tab(refinement)
    has_ladder = (refinement.session.results / LADDER).is_file()
    return (*([suspects] if suspects else []), *([ladder_tab(refinement)] if has_ladder else []))


def viewed_tabs(session: Session, settings: Settings) -> tuple["Tab", ...]:
    """Return the tabs of what a session's results hold, and its curves even where it was not diagnosed."""
    tabs = story_tabs(session, settings)
    shown = None if _has_curves(tabs) else curves_as_measured(session, settings)
    return tabs if shown is None else (curves_tab(shown), *tabs)


def _has_curves(tabs: tuple["Tab", ...]) -> bool:
    from station.views import curves

    return any(tab.name == curves.NAME for tab in tabs)


def story_tabs(session: Session, settings: Settings) -> tuple["Tab", ...]:
    """Return the tabs Compare, Suspects, Curves and Ladder, as far as a session's results hold what they show."""
    results = session.results
    tabs: list[Tab] = []
    if (results / comparison_document.NAME).is_file():
        tabs.append(_compare_tab(session, settings))
    if any((results / name).is_file() for name in (diagnosis_document.NAME, LADDER)):
        try:
            refinement = open_refinement(session, settings)
            tabs += (*_kept_curves_tab(refinement, settings), *kept_tabs(refinement))
        except UsageProblem as problem:  # an effect of the user's own file, which is not at hand here
            progress(f"the tabs Suspects and Ladder are left out: {problem}")
    return tuple(tabs)


def _kept_curves_tab(refinement: Refinement, settings: Settings) -> tuple["Tab", ...]:
    """Return the Curves tab of the diagnosis that a session keeps; nothing when it keeps none that can be read."""
    session = refinement.session
    try:
        document = read_diagnosis(session)
        shown = (
            None
            if document is None
            else kept_curves(session, refinement.prepared, document, refinement.library, settings)
        )
    except UsageProblem as problem:
        progress(f"the tab Curves is left out: {problem}")
        return ()
    return () if shown is None else (curves_tab(shown),)


def _compare_tab(session: Session, settings: Settings) -> "Tab":
    from station.views import compare
    from station.views.tab import Tab

    compared, _ = compare_session(session, settings)
    return Tab(compare.NAME, lambda stream: compare.write(stream, compared), lambda: compare.tab(compared))


def show_suspects(sessions: SessionSet, found: Diagnosis, document: DiagnosisDocument) -> bool:
    """Show a diagnosis in the viewer that is open, or in a new one; False where there is neither."""
    from station.views.open_viewer import url_or_new

    url = url_or_new()
    if url is None:
        return False
    from station.views import show

    shown = diagnosed_curves(sessions.names, sessions.decays, document, found.library)
    curves = () if shown is None else (curves_tab(shown),)
    tabs = (suspects_tab(fits_of(found, document)), *curves)
    show.send_tabs(url, _recording(sessions.sessions[0]), tabs)
    return True


def show_ladder(refinement: Refinement, at: str | None = None) -> bool:
    """Show the ladder in the viewer `at` a URL, else in the one that is open, or in a new one; False where there is none.

    Every call draws under a path of its own, since what a viewer has drawn of a step before may differ.
    """
    from station.views.open_viewer import url_or_new

    url = at or url_or_new()
    if url is None:
        return False
    from station.views import show

    suspects = kept_suspects_tab(refinement)
    tabs = (ladder_tab(refinement, f"/ladder/{time.time_ns()}"), *([suspects] if suspects else []))
    show.send_tabs(url, _recording(refinement.session), tabs)
    return True


def _recording(session: Session) -> str:
    return f"{session.folder.name}-model"
