"""The current model of a session: every command, the page, the viewer and the report use it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from daq.session import Session
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY, find_effect
from identify.formatting import among, plain_name
from identify.model.model import Model, Term, base_model
from station.exits import UsageProblem
from station.results.documents import read_document
from station.results.identification_document import NAME, KeptIdentification
from station.results.ladder import KeptStep, read_ladder
from station.results.models import known_model, read_model
from station.story.pipeline import KnownModel


def current_model(
    sessions: Sequence[Session], file: Path | None = None, library: tuple[Effect, ...] = LIBRARY
) -> KnownModel:
    """Return the model of a file, or `usual`, `identified`, `refined`; without any the current model of the sessions.

    That is the refined model; before any `refine` the first one. Raises UsageProblem where there is none of that name.
    """
    tops = [] if file is not None else _refined(sessions)
    if not any(tops):
        return first_model(sessions, file, library)
    if None in tops or len({tuple(top.effects) for top in tops if top}) > 1:
        remark = "The sessions were refined differently. To begin with the model of one: --model FILE."
        return KnownModel(base_model(), remark=remark)
    return model_of_step(next(top for top in tops if top), library)


def first_model(
    sessions: Sequence[Session], file: Path | None = None, library: tuple[Effect, ...] = LIBRARY
) -> KnownModel:
    """Return the model that a refinement begins with: that of `file`, as `current_model`, else that of the sessions.

    That is the model identified at the orders that the operator chose, where they did, and the usual one otherwise:
    orders that were found in no one's choice may stand for effects of another kind, which are the suspects.
    """
    if file is None:
        return _own(sessions)
    name = "" if file.is_file() else str(file)
    if name == "usual":
        return KnownModel(base_model())
    if name == "identified":
        kept = [kept_identification(session) for session in sessions]
        effects = _alike(sessions, [one.effects if one else () for one in kept], "identified", "identify")
        return KnownModel(model_of(effects), "the identified model")
    if name == "refined":
        tops = _refined(sessions)
        _alike(sessions, [() if top is None else tuple(top.effects) for top in tops], "refined", "refine")
        return model_of_step(next(top for top in tops if top), library)
    return replace(read_model(file, library), words=f"the model of {file}")


def model_of_step(step: KeptStep, library: tuple[Effect, ...] = LIBRARY) -> KnownModel:
    """Return the model of a step of a ladder, with its values."""
    known = known_model(step.model, "the ladder", library)
    states = {name: value for name, value in step.nuisances.items() if ".state" in name}
    return replace(known, words=step.begun_with or f"the {step.name}", states=states)


def kept_identification(session: Session) -> KeptIdentification | None:
    """Return the identification that a session keeps; UsageProblem where it was altered."""
    return read_document(session, NAME, KeptIdentification, "identify it again")


def model_of(names: Sequence[str]) -> Model:
    """Return the model of some effects of the library."""
    return Model(tuple(Term(find_effect(name)) for name in names))


def _refined(sessions: Sequence[Session]) -> list[KeptStep | None]:
    ladders = [read_ladder(session) for session in sessions]
    return [None if ladder is None else ladder.top for ladder in ladders]


def _alike(
    sessions: Sequence[Session], found: Sequence[tuple[str, ...]], done: str, command: str
) -> tuple[str, ...]:
    """Return the effects that all sessions have; UsageProblem where one has none, or other ones."""
    for session, names in zip(sessions, found, strict=True):
        if not names:
            raise UsageProblem(
                f"{session.folder.name}: no model was {done} yet; `station {command}` it first"
            )
    if len(set(found)) > 1:
        raise UsageProblem(f"the sessions were {done} with different models; give a model file, or `usual`")
    return found[0]


def _own(sessions: Sequence[Session]) -> KnownModel:
    kept = [kept_identification(session) for session in sessions]
    chosen = {one.effects if one and one.chosen else () for one in kept}
    if len(chosen) == 1 and (effects := chosen.pop()):
        return KnownModel(model_of(effects), "the identified model, at the orders that were chosen")
    usual = base_model()
    if any(chosen):
        return KnownModel(usual, remark="The sessions were identified at different orders.")
    beyond = [plain_name(name) for one in kept[:1] if one for name in one.effects if name not in usual]
    if not beyond:
        return KnownModel(usual)
    remark = (
        f"The identification also found {among(beyond)}. Another effect may be the cause, so here it is a suspect. "
        "To begin with it: --model identified."
    )
    return KnownModel(usual, remark=remark)
