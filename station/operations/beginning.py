"""The model that a session begins with: the usual one, or that which was identified at orders of the operator's choice."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from daq.session import Session
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY, find_effect
from identify.formatting import among, plain_name
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.results.documents import read_document
from station.results.identification_document import NAME, IdentificationDocument
from station.results.models import read_model, starting_values

USUAL, IDENTIFIED = "usual", "identified"
USUAL_MODEL = "the usual model"
REMEDY = "identify it again"


@dataclass(frozen=True, eq=False)
class Beginning:
    """A model to begin with, and which one it is in `words`; `remark` says why it is not the one that was identified.

    `known` are the values to begin from (None: from the data), `expressions` the operator's own effects in it.
    """

    model: Model
    words: str
    known: dict[str, float] | None = None
    expressions: tuple[str, ...] = ()
    remark: str = ""


def kept_identification(session: Session) -> IdentificationDocument | None:
    """Return the identification that a session keeps; UsageProblem where it was altered."""
    return read_document(session, NAME, IdentificationDocument, REMEDY)


def identified_effects(session: Session) -> tuple[str, ...]:
    """Return the effects of the model that was identified in a session; none where nothing was identified yet."""
    kept = kept_identification(session)
    return () if kept is None or kept.adequacy is None else tuple(kept.adequacy.effects)


def model_of(names: Sequence[str]) -> Model:
    """Return the model of some effects of the library."""
    return Model(tuple(Term(find_effect(name)) for name in names))


def beginning(
    sessions: Sequence[Session],
    decays: tuple[PreparedDecay, ...],
    file: Path | None = None,
    library: tuple[Effect, ...] = LIBRARY,
) -> Beginning:
    """Return the model to begin with: that of a file, `usual`, `identified`, or without any that of the sessions.

    That is the model identified at the orders that the operator chose, where they did, and the usual one otherwise:
    orders that were found in no one's choice may stand for effects of another kind, which are the suspects.
    """
    if file is not None and str(file) == USUAL and not file.is_file():
        return Beginning(base_model(), USUAL_MODEL)
    if file is not None and not (str(file) == IDENTIFIED and not file.is_file()):
        known = read_model(file, library)
        return Beginning(
            known.model, f"the model of {file}", starting_values(known, decays), known.expressions
        )
    if file is not None:
        return _identified(sessions)
    return _own(sessions)


def _identified(sessions: Sequence[Session]) -> Beginning:
    found = [identified_effects(session) for session in sessions]
    for session, names in zip(sessions, found, strict=True):
        if not names:
            raise UsageProblem(
                f"{session.folder.name}: no model was identified yet; `station identify` it first"
            )
    if len(set(found)) > 1:
        raise UsageProblem(
            "the sessions were identified with different models; give a model file, or `usual`"
        )
    return Beginning(model_of(found[0]), "the identified model")


def _own(sessions: Sequence[Session]) -> Beginning:
    kept = [kept_identification(session) for session in sessions]
    chosen = {one.chosen for one in kept if one is not None and one.chosen}
    if len(chosen) == 1 and all(one is not None and one.chosen for one in kept):
        return Beginning(model_of(chosen.pop()), "the identified model, at the orders that were chosen")
    if chosen:
        return Beginning(
            base_model(), USUAL_MODEL, remark="The sessions were identified at different orders."
        )
    usual = base_model()
    found = [name for one in kept[:1] if one and one.adequacy for name in one.adequacy.effects]
    beyond = [plain_name(name) for name in found if name not in usual]
    if not beyond:
        return Beginning(usual, USUAL_MODEL)
    remark = (
        f"The identification found {among(beyond)} besides; such orders may stand for another effect, and so they are "
        "suspects here. To begin with them: --model identified."
    )
    return Beginning(usual, USUAL_MODEL, remark=remark)
