"""The sessions that the operator named, and the library of effects."""

from dataclasses import dataclass
from pathlib import Path

from daq.session import Session
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY
from identify.fitting.segments import largest_first
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.record_floor import prepare_with_floor
from station.results.sessions import open_session
from station.settings import Settings

MOST_SESSIONS = 12


@dataclass(frozen=True, eq=False)
class SessionSet:
    """The sessions that the operator named, and the release of each, ready to be fitted, the largest first."""

    sessions: tuple[Session, ...]
    decays: tuple[PreparedDecay, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the sessions."""
        return tuple(session.folder.name for session in self.sessions)


def open_sessions(
    arguments: tuple[str, ...], settings: Settings, gain_percent: float | None = None
) -> SessionSet:
    """Open sessions (or data files, which are imported) and prepare their releases, the largest first.

    `gain_percent` replaces what the sensors' certificates say. Raises UsageProblem when the sessions do not
    belong together, NotIdentifiable when one holds too little.
    """
    if len(arguments) > MOST_SESSIONS:
        raise UsageProblem(f"{len(arguments)} sessions are too many at once; give at most {MOST_SESSIONS}")
    sessions = tuple(open_session(argument, settings.sessions) for argument in arguments)
    folders = [session.folder.resolve() for session in sessions]
    if len(set(folders)) < len(folders):
        raise UsageProblem("one session was given twice; each release counts once")
    decays = tuple(prepare_with_floor(session, settings, gain_percent) for session in sessions)
    _check_alike(sessions, decays)
    order = largest_first(decays)
    return SessionSet(tuple(sessions[i] for i in order), tuple(decays[i] for i in order))


def _check_alike(sessions: tuple[Session, ...], decays: tuple[PreparedDecay, ...]) -> None:
    first = decays[0].window
    for session, prepared in zip(sessions[1:], decays[1:], strict=True):
        window = prepared.window
        if window.channels != first.channels or window.unit != first.unit:
            raise UsageProblem(
                f"{session.folder.name} has {', '.join(window.channels)} in {window.unit}, {sessions[0].folder.name} has "
                f"{', '.join(first.channels)} in {first.unit}; diagnose together what was measured alike"
            )


def whole_library(file: Path | None) -> tuple[Effect, ...]:
    """Return the library with the user's own effects from a Python file after it."""
    if file is None:
        return LIBRARY
    from station.own_effects import load_effects

    try:
        own = load_effects(file)
    except OSError as error:
        raise UsageProblem(f"the effects {file} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise UsageProblem(str(error)) from error
    taken = {effect.name for effect in LIBRARY}
    for effect in own:
        if effect.name in taken:
            raise UsageProblem(f"{file}: {effect.name} is in the library already; choose another name")
        taken.add(effect.name)
    return (*LIBRARY, *own)
