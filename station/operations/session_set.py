"""Sessions made ready for a model: from a recording to the setting of a fit, with all that it needs."""

import math
from dataclasses import dataclass
from pathlib import Path

from daq.recording import Recording
from daq.session import Session
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import initial_values
from identify.model.model import Model, base_model
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from station.exits import UsageProblem
from station.operations.identifying import options_for
from station.results.models import KnownModel, read_model
from station.results.sessions import open_session
from station.settings import Settings
from station.story.pipeline import MOTION, find_motion, free_decay

MOST_SESSIONS = 12


@dataclass(frozen=True, eq=False)
class SessionSet:
    """The sessions that the operator named, each made ready to be fitted."""

    sessions: tuple[Session, ...]
    settings: tuple[PreparedDecay, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the sessions."""
        return tuple(session.folder.name for session in self.sessions)


def open_sessions(
    arguments: tuple[str, ...], settings: Settings, gain_percent: float | None = None
) -> SessionSet:
    """Open sessions (or data files, which are imported) and make them ready.

    `gain_percent` replaces what the sensors' certificates say. Raises UsageProblem when the sessions do not
    belong together, NotIdentifiable when one holds too little.
    """
    if len(arguments) > MOST_SESSIONS:
        raise UsageProblem(f"{len(arguments)} sessions are too many at once; give at most {MOST_SESSIONS}")
    sessions = tuple(open_session(argument, settings.sessions) for argument in arguments)
    folders = [session.folder.resolve() for session in sessions]
    if len(set(folders)) < len(folders):
        raise UsageProblem("one session was given twice; each release counts once")
    made = tuple(make_ready(session, settings, gain_percent) for session in sessions)
    _check_alike(sessions, made)
    return SessionSet(sessions, made)


def make_ready(session: Session, settings: Settings, gain_percent: float | None = None) -> PreparedDecay:
    """Return the setting of one session: recording -> release -> alignment and motion."""
    recording = session.recording()
    decay = free_decay(recording, options_for(session, settings))
    release = find_motion(decay)
    decay = decay.with_(release=release.index, rest=release.rest)
    gain = gain_uncertainty(recording) if gain_percent is None else gain_percent / 100.0
    try:
        return prepare(decay, release, gain_uncertainty=gain)
    except NotIdentifiable as refusal:
        raise NotIdentifiable(f"{session.folder.name}: {refusal}") from refusal


def gain_uncertainty(recording: Recording) -> float:
    """Return the relative uncertainty of the gain between the two channels, as their certificates leave it."""
    parts = []
    for quantity in MOTION:
        first = next((c for c in recording.channels if c.quantity == quantity), None)
        if first is not None and first.calibration_uncertainty is not None:
            parts.append(first.calibration_uncertainty)
    return math.sqrt(sum(part**2 for part in parts))


def _check_alike(sessions: tuple[Session, ...], settings: tuple[PreparedDecay, ...]) -> None:
    first = settings[0].window
    for session, setting in zip(sessions[1:], settings[1:], strict=True):
        window = setting.window
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


def chosen_model(
    file: Path | None, settings: tuple[PreparedDecay, ...], library: tuple[Effect, ...]
) -> tuple[Model, dict[str, float] | None, tuple[str, ...]]:
    """Return the model to begin with, the values to begin from (None: from the data), and its expressions."""
    if file is None:
        return base_model(), None, ()
    known = read_model(file, library)
    return known.model, begin_from(known, settings), known.expressions


def begin_from(known: KnownModel, settings: tuple[PreparedDecay, ...]) -> dict[str, float]:
    """Return where a fit may begin, by unknown's name: the file's values, the releases' own from their motions."""
    start = initial_values(settings, known.model, known.values)
    for term in known.model.terms:
        for parameter in term.free:
            id = term.parameter(parameter.name)
            if str(id) not in known.values:
                continue
            for i in range(1 if term.is_force else len(settings)):
                own = id if term.is_force else id.of_release(i, len(settings))
                start[str(own)] = known.values[str(id)]
    return start
