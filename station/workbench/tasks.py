"""What a worker does for the page: each task calls what the commands call, and returns plain values."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from daq.session import Session
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.comparing import compare_ready, setting_of
from station.operations.diagnosing import diagnose_sessions, keep
from station.operations.identifying import options_for
from station.operations.refining import Refinement, add, climb_on, go_to, open_refinement, remove
from station.operations.session_set import SessionSet
from station.results.ladder import LADDER, MODEL, KeptLadder, read_ladder, write_ladder
from station.settings import Settings
from station.workbench import view_models
from station.workbench.build_view_models import effects_of, kept_diagnosis, picture_of, results_stamp
from station.workbench.force_map import prints_of, prints_of_kept
from station.workbench.session_thumbnails import portrait_of
from station.workbench.warm_up import warm_up

Tell = Callable[[str], None]

MOST_OPEN = 8


@dataclass(frozen=True, eq=False)
class _Opened:
    """A session made ready, kept while the process lives; `stamp` tells whether it is still the same file."""

    stamp: tuple[int, ...]
    refinement: Refinement
    setting: PreparedDecay


_opened: dict[Path, _Opened] = {}


def _open(settings: Settings, folder: Path) -> _Opened:
    session = Session.open(folder)
    raw = (folder / "raw.log").stat()
    ladder = read_ladder(session)
    stamp = (raw.st_mtime_ns, raw.st_size, hash(ladder.gain_percent if ladder else None))
    known = _opened.get(folder)
    if known is None or known.stamp != stamp:
        refinement = open_refinement(session, settings)
        known = _Opened(stamp, refinement, setting_of(session, options_for(session, settings)))
        while len(_opened) >= MOST_OPEN:
            _opened.pop(next(iter(_opened)))
        _opened[folder] = known
    if ladder is None:
        return known
    return replace(known, refinement=replace(known.refinement, ladder=ladder, session=session))


def look(settings: Settings, tell: Tell, folder: Path) -> view_models.View:
    """Return what the page shows of a session, as its results stand."""
    tell("reading the session")
    opened = _open(settings, folder)
    return _view(settings, opened, opened.refinement.ladder)


def _view(settings: Settings, opened: _Opened, ladder: KeptLadder) -> view_models.View:
    session = opened.refinement.session
    is_kept = (session.results / LADDER).is_file()
    model = session.results / MODEL if is_kept else None
    mass = options_for(session, settings).mass
    compared, document = compare_ready(session, opened.setting, mass, model)
    diagnosis = kept_diagnosis(session)
    return view_models.View(
        session.folder.name,
        ladder,
        is_kept,
        picture_of(compared, document),
        diagnosis,
        effects_of(ladder, diagnosis),
        results_stamp(session.folder),
    )


def add_effect(settings: Settings, tell: Tell, folder: Path, wanted: str) -> view_models.View:
    """Add an effect by name, or an expression as "magnet = a*u"."""
    tell(f"adding {wanted.partition('=')[0].strip()}")
    opened = _open(settings, folder)
    return _view(settings, opened, add(opened.refinement, wanted))


def remove_effect(settings: Settings, tell: Tell, folder: Path, name: str) -> view_models.View:
    """Take an effect out of the model."""
    tell(f"taking {name} out")
    opened = _open(settings, folder)
    return _view(settings, opened, remove(opened.refinement, name))


def go_to_rung(settings: Settings, tell: Tell, folder: Path, number: int) -> view_models.View:
    """Make a rung of the ladder the present model."""
    tell(f"going to rung {number}")
    opened = _open(settings, folder)
    return _view(settings, opened, go_to(opened.refinement, number))


def climb(settings: Settings, tell: Tell, folder: Path) -> view_models.View:
    """Add what is missing until nothing is."""
    tell("looking for what is missing")
    opened = _open(settings, folder)
    return _view(settings, opened, climb_on(opened.refinement, tell))


def begin_again(settings: Settings, tell: Tell, folder: Path) -> view_models.View:
    """Begin the ladder again with the base model."""
    tell("beginning again")
    opened = _open(settings, folder)
    refinement = open_refinement(opened.refinement.session, settings, reset=True)
    write_ladder(refinement.session, refinement.ladder)
    return _view(settings, opened, refinement.ladder)


def diagnose(
    settings: Settings, tell: Tell, folder: Path
) -> tuple[view_models.View, dict[str, view_models.Print]]:
    """Ask what the present model lacks, keep the answer, and return it with its fingerprints."""
    opened = _open(settings, folder)
    refinement = opened.refinement
    session = refinement.session
    sessions = SessionSet((session,), (refinement.setting,))
    model = session.results / MODEL if (session.results / LADDER).is_file() else None
    found, document = diagnose_sessions(sessions, model, None, tell)
    keep(sessions, document)
    return _view(settings, opened, refinement.ladder), prints_of(refinement.setting, found)


def prints(settings: Settings, tell: Tell, folder: Path) -> dict[str, view_models.Print]:
    """Return the fingerprints of the diagnosis that a session keeps."""
    opened = _open(settings, folder)
    document = kept_diagnosis(opened.refinement.session)
    return {} if document is None else prints_of_kept(opened.refinement, document)


def portrait(settings: Settings, tell: Tell, folder: Path) -> view_models.Portrait:
    """Return a session's amplitude and sparkline."""
    return portrait_of(folder)


def import_file(
    settings: Settings,
    tell: Tell,
    file: Path,
    columns: dict[str, str | int],
    units: dict[str, str],
    rate: float | None,
    mass: float | None,
) -> tuple[list[str], list[str]]:
    """Import a data file; return the names of the sessions and what was understood."""
    from daq.importing.options import ImportOptions
    from station.operations.new_session import session_info
    from station.results.sessions import import_file as make

    tell(f"reading {file.name}")
    info = session_info(settings, mass, None, None, None)
    options = ImportOptions(columns=columns, units=units, rate=rate)
    imported = make(file, None, settings.sessions, options, info)
    return [session.folder.name for session in imported.sessions], list(imported.notes)


def open_example(settings: Settings, tell: Tell, name: str) -> str:
    """Import a recording that comes with the station, unless it is there already; return its session's name."""
    from station.operations.examples import open_example as opened

    tell(f"reading {name}")
    return opened(name, settings.sessions).folder.name


def viewer(settings: Settings, tell: Tell, folder: Path, aside: Path) -> int:
    """Write the recording that `station view` writes, and the viewer's own files; return the recording's age (ns)."""
    from station.operations.identifying import identify_session, write_view
    from station.operations.viewer_tabs import story_tabs
    from station.views import web_viewer

    session = Session.open(folder)
    tell("identifying")
    result, _ = identify_session(session, options_for(session, settings))
    tell("writing the recording")
    file = write_view(session, result, story_tabs(session, settings))
    if not (aside / web_viewer.FILES[0]).is_file():
        web_viewer.unpack(aside)
    return file.stat().st_mtime_ns


def report(settings: Settings, tell: Tell, folder: Path) -> str:
    """Write the report of a session; return its path."""
    from station.report.write import write_report

    tell("writing the report")
    return str(write_report(Session.open(folder), settings=settings, tell=tell))


def warm(settings: Settings, tell: Tell) -> None:
    """Compile what the other tasks need."""
    warm_up()


TASKS: dict[str, Callable[..., Any]] = {
    "look": look,
    "add": add_effect,
    "remove": remove_effect,
    "go": go_to_rung,
    "climb": climb,
    "again": begin_again,
    "diagnose": diagnose,
    "prints": prints,
    "portrait": portrait,
    "import": import_file,
    "example": open_example,
    "viewer": viewer,
    "report": report,
    "warm": warm,
}
