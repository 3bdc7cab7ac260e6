"""Sessions that are looked at together: those that the operator named, and those that were diagnosed with one."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from daq.errors import StationError
from daq.session import Session
from identify.errors import NotIdentifiable
from identify.fitting.own_linear import VARIES, changed_on_purpose
from identify.fitting.segments import largest_first
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import Problem, UsageProblem
from station.operations.refining import Refinement
from station.results.diagnosis_document import DiagnosisDocument
from station.results.diagnosis_pictures import NamedCurves, diagnosed_curves
from station.results.session_names import session_folder
from station.results.sessions import open_session
from station.settings import Settings
from station.story.preparation import prepare_session
from station.suggestions import did_you_mean

MOST_SESSIONS = 12

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False)
class SessionSet:
    """The sessions that the operator named, and the release of each, ready to be fitted, the largest first.

    `varies` is what was changed on purpose between them; `left_out` says why a session holds too little, by its name.
    """

    sessions: tuple[Session, ...]
    decays: tuple[PreparedDecay, ...]
    varies: frozenset[str] = frozenset()
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the sessions."""
        return tuple(session.folder.name for session in self.sessions)


def open_sessions(
    arguments: tuple[str, ...], settings: Settings, varies: frozenset[str] = frozenset()
) -> SessionSet:
    """Open sessions (or data files, which are imported) and prepare their releases, the largest first.

    `varies` is what was changed on purpose, beside what the sessions' metadata say. Of several sessions those that hold
    too little are left out. Raises UsageProblem when the sessions do not belong together, NotIdentifiable when all hold
    too little.
    """
    if len(arguments) > MOST_SESSIONS:
        raise UsageProblem(f"{len(arguments)} sessions are too many at once; give at most {MOST_SESSIONS}")
    sessions = opened_once(arguments, settings)
    several = len(sessions) > 1
    ready, left_out = of_each(
        sessions, lambda session: prepare_session(session, settings, beside_others=several)
    )
    if several and len(ready) == 1:  # alone after all, by the rule for one
        ready, too_short = of_each([ready[0][0]], lambda session: prepare_session(session, settings))
        left_out |= too_short
    if not ready:
        raise NotIdentifiable(" ".join(by_reason(left_out)))
    sessions, decays = (tuple(part) for part in zip(*ready, strict=True))
    _check_alike(sessions, decays)
    order = largest_first(decays)
    sessions, decays = tuple(sessions[i] for i in order), tuple(decays[i] for i in order)
    varies |= declared(session.info.varies for session in sessions)
    if len(decays) > 1:
        decays = changed_on_purpose(decays, varies)
    return SessionSet(sessions, decays, varies, left_out)


def of_each(
    sessions: Iterable[Session], act: Callable[[Session], Result]
) -> tuple[list[tuple[Session, Result]], dict[str, str]]:
    """Do something with each session; return what came of it, and why sessions hold too little for it, by their names."""
    done: list[tuple[Session, Result]] = []
    left_out: dict[str, str] = {}
    for session in sessions:
        try:
            done.append((session, act(session)))
        except NotIdentifiable as refusal:
            left_out[session.folder.name] = str(refusal).removeprefix(f"{session.folder.name}: ")
    return done, left_out


def by_reason(left_out: dict[str, str]) -> list[str]:
    """Write each reason once, after the names of all that were left out for it: "a, b: too short"."""
    names: dict[str, list[str]] = {}
    for name, why in left_out.items():
        names.setdefault(why, []).append(name)
    return [f"{', '.join(found)}: {why}" for why, found in names.items()]


def opened_once(arguments: Sequence[str], settings: Settings) -> tuple[Session, ...]:
    """Open sessions (or data files); UsageProblem where one is not there, or two arguments mean the same one."""
    for argument in arguments:  # before a file is imported
        session_folder(argument, settings.sessions, "session or data file")
    sessions = tuple(open_session(argument, settings.sessions) for argument in arguments)
    if len({session.folder.resolve() for session in sessions}) < len(sessions):
        raise UsageProblem("one session was given twice; each release counts once")
    return sessions


def declared(names: Iterable[Sequence[str]]) -> frozenset[str]:
    """Read lists of what was changed on purpose; UsageProblem for a name that is none of VARIES."""
    found = frozenset(name.strip() for several in names for name in several)
    for name in sorted(found - set(VARIES)):
        raise UsageProblem(
            f"'{name}' cannot vary between sessions{did_you_mean(name, VARIES)}; {', '.join(VARIES)} can"
        )
    return found


def _check_alike(sessions: tuple[Session, ...], decays: tuple[PreparedDecay, ...]) -> None:
    first = decays[0].window
    for session, prepared in zip(sessions[1:], decays[1:], strict=True):
        window = prepared.window
        if window.channels != first.channels or window.unit != first.unit:
            raise UsageProblem(
                f"{session.folder.name} has {', '.join(window.channels)} in {window.unit}, {sessions[0].folder.name} has "
                f"{', '.join(first.channels)} in {first.unit}; only sessions with the same channels and unit go together"
            )


def kept_curves(
    refinement: Refinement, document: DiagnosisDocument, settings: Settings
) -> NamedCurves | None:
    """Return the curves of a session and of those beside it that were diagnosed together; None where it has none.

    Sessions that are gone, or cannot be read, are left out. Raises UsageProblem when an effect is not in the library.
    """
    session, prepared = refinement.session, refinement.prepared
    found = [(session.folder.name, prepared)]
    for other in diagnosed_beside(session, document):
        decay = prepared_or_none(other, settings)
        if decay is not None and decay.window.channels == prepared.window.channels:
            found.append((other.folder.name, decay))
    names, decays = zip(*found, strict=True)
    return diagnosed_curves(names, decays, document, refinement.library)


def diagnosed_beside(session: Session, document: DiagnosisDocument) -> tuple[Session, ...]:
    """Open the sessions in the same folder that a diagnosis looked at together with this one, those that are still there."""
    place, own = session.folder.parent, session.folder.name
    folders = [place / name for name in document.sessions if name != own]
    opened = (opened_or_none(folder) for folder in folders if folder.parent == place)
    return tuple(one for one in opened if one is not None)


def opened_or_none(folder: Path) -> Session | None:
    """Open a session; None where the folder is gone, or is none."""
    try:
        return Session.open(folder)
    except (StationError, OSError):
        return None


def prepared_or_none(session: Session, settings: Settings) -> PreparedDecay | None:
    """Prepare the release of a session; None where it holds too little or cannot be read."""
    try:
        return prepare_session(session, settings)
    except (StationError, Problem, NotIdentifiable, OSError):
        return None
