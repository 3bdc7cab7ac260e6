"""What a worker does for the page: each task calls what the commands call, and returns plain values."""

import contextlib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from daq.importing.recipe import Recipe
from daq.session import Session
from identify.errors import NotIdentifiable
from station.exits import Problem
from station.operations.comparing import compare_session
from station.operations.current_model import current_model
from station.operations.diagnosing import diagnose_sessions, keep, physics_shared
from station.operations.refining import Refinement, add, drop_needless, go_to, open_refinement, remove
from station.operations.refining import refine_to_floor as climb
from station.operations.session_set import SessionSet, open_sessions
from station.results.diagnosis_document import DiagnosisDocument, with_differences
from station.results.ladder import KeptLadder, write_ladder
from station.settings import Settings
from station.story.pipeline import Progress, silent
from station.story.preparation import weighing_of
from station.text.ladder_text import with_mass
from station.workbench import further_tasks, telling, view_models
from station.workbench.build_view_models import equations_of, results_stamp
from station.workbench.frame_store import MEASURED_CURVE, frame_of_tried, of_ladder, of_step, of_suspects
from station.workbench.frames import frame_id
from station.workbench.opened_session import Opened, kept_diagnosis, open_session
from station.workbench.session_thumbnails import outline, thumbnail_of
from station.workbench.several_files import import_files
from station.workbench.warm_up import warm_up


def look(settings: Settings, progress: Progress, folder: Path) -> view_models.View:
    """View a session as its results stand."""
    progress("reading the session")
    opened = open_session(settings, folder)
    return _view(settings, opened, opened.refinement.ladder)


def _view(settings: Settings, opened: Opened, ladder: KeptLadder) -> view_models.View:
    """View a ladder; the frame of the present step comes with it, the others when `frames` is asked."""
    session, store = opened.refinement.session, opened.store
    diagnosis = kept_diagnosis(session)
    names = tuple(frame_id(step.model) for step in ladder.steps)
    weighing = weighing_of(session, settings, opened.refinement.prepared.window.unit)
    of_step(store, opened.refinement, ladder.top)
    return view_models.View(
        ladder,
        diagnosis,
        equations_of(ladder),
        results_stamp(session.folder),
        None if store.ground is None else store.ground.stage,
        {name: store.frames[name] for name in names if name in store.frames},
        names,
        with_mass={} if weighing is None else with_mass(ladder.top, weighing),
        mystery=session.info.specimen.startswith("mystery "),
    )


def summary(settings: Settings, progress: Progress, folder: Path) -> str:
    """Compare the present model with the measurement; return the sentence on where it fails."""
    progress("comparing with the measurement")
    refinement = open_session(settings, folder).refinement
    compared, _ = compare_session(refinement.session, settings, prepared=refinement.prepared)
    return compared.comparison.summary


def ladder_task(
    words: str, change: Callable[[Refinement, Any], KeptLadder]
) -> Callable[..., view_models.View]:
    """Make a task that changes the ladder by one thing that is wanted, and says it in `words`."""

    def task(settings: Settings, progress: Progress, folder: Path, wanted: Any) -> view_models.View:
        progress(words.format(wanted).partition("=")[0].strip())
        opened = open_session(settings, folder)
        return _view(settings, opened, change(opened.refinement, wanted))

    return task


def refine_to_floor(settings: Settings, progress: Progress, folder: Path) -> view_models.View:
    """Add what is missing until nothing is; each step is sent as a view as soon as it is found."""
    progress("looking for what is missing")
    opened = open_session(settings, folder)

    def seen(ladder: KeptLadder, words: str) -> None:
        progress(_view(settings, opened, ladder))  # type: ignore[arg-type]
        progress(words)

    return _view(settings, opened, climb(opened.refinement, silent, seen))


def begin_again(settings: Settings, progress: Progress, folder: Path) -> view_models.View:
    """Begin the ladder again with the base model."""
    progress("beginning again")
    opened = open_session(settings, folder)
    refinement = open_refinement(opened.refinement.session, settings, reset=True)
    return _view(settings, opened, write_ladder(refinement.session, refinement.ladder))


def prune(settings: Settings, progress: Progress, folder: Path) -> view_models.View:
    """Take out the effects without which the misfit hardly rises."""
    progress("trying to do without each effect")
    opened = open_session(settings, folder)
    ladder, words = drop_needless(opened.refinement)
    return replace(_view(settings, opened, ladder), note=words)


def restore(refinement: Refinement, ladder: KeptLadder) -> KeptLadder:
    """Keep a ladder as it was before a change; it follows what is kept now."""
    return write_ladder(refinement.session, ladder.with_(seen=refinement.ladder.seen))


def diagnose(
    settings: Settings, progress: Progress, folder: Path, others: tuple[Path, ...] = ()
) -> view_models.View:
    """Ask what the present model lacks on this release, and on others with it, keep the answer, and return it."""
    opened = open_session(settings, folder)
    refinement = opened.refinement
    session = refinement.session
    sessions = SessionSet((session,), (refinement.prepared,))
    shared = None
    if others:
        sessions = open_sessions((str(folder), *(str(other) for other in others)), settings)
        progress("asking whether the releases share their physics")
        shared = physics_shared(sessions, False, progress)
    _, document = diagnose_sessions(sessions, current_model((session,)), None, progress, progress)
    document = document if shared is None else with_differences(document, shared)
    keep(sessions, document)
    return _view(settings, opened, refinement.ladder)


def frames(
    settings: Settings, progress: Progress, folder: Path, document: DiagnosisDocument | None = None
) -> view_models.Drawn:
    """Return the frames of all steps and of a diagnosis' suspects; each suspect's is sent as soon as it is drawn."""
    opened = open_session(settings, folder)
    refinement, store = opened.refinement, opened.store
    of_ladder(store, refinement, refinement.ladder, progress)
    suspects: dict[str, str] = {}
    for one in () if document is None else of_suspects(store, refinement, document):
        suspects |= one.suspects
        progress(one)  # type: ignore[arg-type]
    found = dict(store.frames)
    if document is not None and document.suspects and not refinement.ladder.top.at_floor:
        progress("drawing the measured curve")
        with contextlib.suppress(Problem, NotIdentifiable):  # it has no card then
            name, frame = frame_of_tried(store, refinement, MEASURED_CURVE, "the measured curve")
            found[name], suspects[MEASURED_CURVE] = frame, name
    return view_models.Drawn(found, suspects)


def import_file(
    settings: Settings,
    progress: Progress,
    file: Path,
    recipe: Recipe | None,
    ask: bool,
    mass: float | None,
) -> tuple[list[str], list[str]] | view_models.ImportQuestion:
    """Import a data file; return the names of the sessions and what was understood, or what is to be said first."""
    from daq.importing.options import ImportOptions
    from daq.importing.propose import Doubtful
    from station.operations.new_session import session_info
    from station.results.kept_recipes import look_with_kept
    from station.results.sessions import import_file as make

    progress(f"reading {file.name}")
    info = session_info(settings, mass, None, None, None)
    try:
        if ask:
            known = look_with_kept(file, settings.sessions)[0].read().recipe
            return _question(file, known, f"{file.name}: what the columns seem to be")
        imported = make(file, None, settings.sessions, ImportOptions(), info, recipe)
    except Doubtful as refusal:
        doubts = (doubt.partition("; ")[0] for doubt in refusal.proposal.doubts)  # what to do is on the page
        return _question(file, refusal.proposal.recipe, f"{file.name}: {'; '.join(doubts)}")
    return [session.folder.name for session in imported.sessions], list(imported.notes)


def _question(file: Path, recipe: Recipe, sentence: str) -> view_models.ImportQuestion:
    from daq.importing.apply import matched
    from daq.importing.reading import read_table

    table = read_table(file, recipe)
    found = {id(field): number for number, field in matched(table, recipe).items()}
    columns = {column.number: column for column in table.columns}
    asked = []
    for field in recipe.fields:
        column = columns[found[id(field)]]
        first = ", ".join(f"{value:.5g}" for value in column.values[:4])
        asked.append(view_models.AskedColumn(column.place, first, outline(column.values)[1]))
    return view_models.ImportQuestion(sentence, recipe, tuple(asked))


def open_example(settings: Settings, progress: Progress, name: str) -> str:
    """Import a recording that comes with the station, unless it is there already; return its session's name."""
    from station.operations.examples import open_example as opened

    progress(f"reading {name}")
    return opened(name, settings.sessions).folder.name


def viewer(settings: Settings, progress: Progress, folder: Path, temporary: Path, dark: bool) -> int:
    """Write the recording that `station view` writes, and the viewer's own files; return the recording's age (ns)."""
    from station.operations.identifying import identify_session, kept_options, write_view
    from station.operations.viewer_tabs import kept_tabs
    from station.views import web_viewer

    session = Session.open(folder)
    progress("identifying")
    result, _ = identify_session(session, kept_options(session, settings))
    progress("writing the recording")
    file = write_view(session, result, kept_tabs(session, settings), dark=dark)
    if not (temporary / web_viewer.FILES[0]).is_file():
        web_viewer.unpack(temporary)
    return file.stat().st_mtime_ns


def report(settings: Settings, progress: Progress, folder: Path) -> str:
    """Write the report of a session; return its path."""
    from station.report.write import write_report

    progress("writing the report")
    return str(write_report(Session.open(folder), settings=settings, progress=progress).path)


TASKS: dict[str, Callable[..., Any]] = {
    "look": look,
    "add": ladder_task("adding {}", add),
    "remove": ladder_task("taking {} out", remove),
    "go": ladder_task("going to step {}", go_to),
    "refine": refine_to_floor,
    "again": begin_again,
    "diagnose": diagnose,
    "frames": frames,
    "summary": summary,
    "compared": telling.compared,
    "restore": ladder_task("undoing the last change", restore),
    "prune": prune,
    "recorded": telling.recorded,
    "identified": telling.identified,
    "validated": telling.validated,
    "export": further_tasks.export,
    "reveal": further_tasks.reveal,
    "preview": further_tasks.preview,
    "thumbnail": lambda settings, progress, folder: thumbnail_of(folder),
    "import": import_file,
    "files": import_files,
    "example": open_example,
    "viewer": viewer,
    "report": report,
    "warm": lambda settings, progress: warm_up(),
}
