"""Validate a model: predict sessions that it was not fitted to, beside the usual model."""

from dataclasses import dataclass
from pathlib import Path

from daq.plain_text import counted
from daq.session import Session
from identify.effects.effect import Effect
from identify.effects.force_effect import LinearPart
from identify.errors import NotIdentifiable
from identify.fitting.own_linear import changed_on_purpose
from identify.fitting.parameter_layout import in_unit
from identify.fitting.validation import Validated, validate
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.session_set import (
    by_reason,
    declared,
    diagnosed_beside,
    of_each,
    opened_once,
    opened_or_none,
    prepared_or_none,
)
from station.own_effects import whole_library
from station.results.diagnosis_document import read_diagnosis
from station.results.documents import RefusedSession, keep_document
from station.results.ladder import read_ladder
from station.results.models import ModelFile, known_model, read_model_file
from station.results.sessions import open_session
from station.results.validation_document import NAME, ValidatedDocument, ValidationDocument
from station.settings import Settings
from station.story.pipeline import KnownModel, Progress, silent
from station.story.preparation import prepare_session
from station.text.validation_text import left

OWN = "the model was fitted to it"


@dataclass(frozen=True, eq=False)
class GivenModel:
    """A model to validate: its source, its file with the units of its parameters, and the sessions it was fitted to."""

    source: str
    file: ModelFile
    known: KnownModel
    fitted_to: tuple[Session, ...]


def validate_sessions(
    model: str,
    sessions: tuple[str, ...],
    settings: Settings,
    effects_file: Path | None = None,
    *,
    hold: bool = False,
    varies: tuple[str, ...] = (),
    progress: Progress = silent,
) -> ValidationDocument:
    """Predict sessions by a model (a file, or a session that keeps one); keep the document in each of them.

    `varies` names what was changed on purpose from what the model was fitted to, beside what the sessions'
    metadata say: each session has its own of that.

    Sessions that hold too little, and those that the model was fitted to, are skipped, which is said. Raises
    NotIdentifiable where all hold too little, UsageProblem where the model does not suit a session.
    """
    given = open_model(model, settings, whole_library(effects_file))
    opened = opened_once(sessions, settings)
    ready, skipped = _prepared(opened, given, settings, progress)
    names = tuple(session.folder.name for session, _ in ready)
    changed = declared([varies, *(session.info.varies for session, _ in ready)])
    strength = given.known.model.linear_strength(LinearPart.STIFFNESS)
    spring = 0.0 if strength is None else float(given.known.values[str(strength)])
    decays = changed_on_purpose([decay for _, decay in ready], changed, spring)
    known = [prepared_or_none(session, settings) for session in given.fitted_to]
    own = changed_on_purpose([decay for decay in known if decay is not None], changed, spring)
    progress(f"fitting the usual model, and predicting {counted(len(decays), 'session', 'sessions')}")

    def report(one: Validated) -> None:
        progress(
            f"{names[one.index]}, residual in % of the motion: {left(one.usual.motion_percent)} by the usual model, "
            f"{left(one.model.motion_percent)} by this one"
        )

    found = validate(given.known.model, given.known.values, decays, fitted_to=own, hold=hold, progress=report)
    fitted_to = tuple(session.folder.name for session in given.fitted_to)
    predicted = [ValidatedDocument.of(one, session=names[one.index]) for one in found.releases]
    why = [RefusedSession(session=name, reason=reason) for name, reason in skipped.items()]
    known_as = {"format": 1, "source": given.source, "fitted_to": fitted_to, "model": given.file}
    document = ValidationDocument.of(found, sessions=predicted, skipped=why, **known_as)
    for session, _ in ready:
        keep_document(session, NAME, document, progress)
    return document


def open_model(argument: str, settings: Settings, library: tuple[Effect, ...]) -> GivenModel:
    """Return the model in a file, or the one that a session keeps: that of its ladder, else that of its diagnosis."""
    path = Path(argument)
    fitted_to: tuple[Session, ...]
    if path.is_file():
        file, source, said = read_model_file(path), argument, f"the model {path}"
        place = path.resolve().parent
        session = opened_or_none(place.parent) if place.name == "results" else None
        fitted_to = () if session is None else (session,)
    else:
        session = open_session(argument, settings.sessions, what="model file or session")
        source, said = session.folder.name, f"the model of {session.folder.name}"
        file, fitted_to = _kept_model(session)
    return GivenModel(source, file, known_model(file, said, library), fitted_to)


def _kept_model(session: Session) -> tuple[ModelFile, tuple[Session, ...]]:
    """Return the model that a session keeps, and the sessions that it was fitted to."""
    usual = set(base_model().names)
    ladder = read_ladder(session)
    if ladder is not None and set(ladder.top.effects) != usual:
        return ladder.top.model, (session,)
    diagnosis = read_diagnosis(session)
    # The model with what it named, else that which was asked about.
    file = None if diagnosis is None else diagnosis.final or diagnosis.fitted
    if diagnosis is None or file is None or set(file.names) == usual:
        raise UsageProblem(
            f"{session.folder.name} keeps no model but the usual one; `station diagnose` or `station refine` it first, "
            "or give a model file"
        )
    return file, (session, *diagnosed_beside(session, diagnosis))


def _prepared(
    opened: tuple[Session, ...], given: GivenModel, settings: Settings, progress: Progress
) -> tuple[list[tuple[Session, PreparedDecay]], dict[str, str]]:
    """Return the sessions that can be predicted, prepared, and why others cannot."""
    own = {session.folder.resolve() for session in given.fitted_to}
    new = [session for session in opened if session.folder.resolve() not in own]
    skipped = {session.folder.name: OWN for session in opened if session not in new}
    if not new:
        raise UsageProblem(f"{', '.join(skipped)}: {OWN}; give sessions that it has not seen")
    ready, too_little = of_each(new, lambda session: prepare_session(session, settings))
    skipped |= too_little
    if not ready:
        raise NotIdentifiable(f"no session can be predicted: {'; '.join(by_reason(skipped))}")
    for session, decay in ready:
        _check_suits(given, session.folder.name, decay)
    for reason in by_reason(skipped):
        progress(f"skipped: {reason}")
    return ready, skipped


def _check_suits(given: GivenModel, name: str, decay: PreparedDecay) -> None:
    """Raise UsageProblem where a model is in other units than a session."""
    unit = decay.window.unit
    for entry, term in zip(given.file.effects, given.known.model.terms, strict=True):
        if not term.effect.has_meaning_for(unit):
            raise UsageProblem(
                f"{name} has a displacement in {unit}, for which {entry.effect} of the model has no meaning"
            )
        units = {p.name: in_unit(p.unit, unit) for p in term.free} if term.is_force else {}
        for parameter, value in entry.parameters.items():
            expected = units.get(parameter)
            if value.unit and expected is not None and value.unit != expected:
                raise UsageProblem(
                    f"{name} has a displacement in {unit}, the model another unit: {entry.effect}.{parameter} is in "
                    f"{value.unit}, not in {expected}; validate it on sessions in the unit that it was fitted in"
                )
