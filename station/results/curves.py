"""Curves of sessions with the laws of their diagnosis, made from the records and the document whenever they are drawn."""

from dataclasses import dataclass, replace

from identify.curves.laid_over import DecayCurves, Law, Role, decay_curves
from identify.effects.effect import Effect
from identify.errors import NotIdentifiable
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument
from station.results.models import ModelFile, known_model

MOST_RIVALS = 2


@dataclass(frozen=True, eq=False)
class NamedCurves:
    """Curves of some releases; `names` are those of the sessions that were given, by the releases' places."""

    names: tuple[str, ...]
    curves: DecayCurves


def diagnosed_curves(
    names: tuple[str, ...],
    decays: tuple[PreparedDecay, ...],
    document: DiagnosisDocument,
    library: tuple[Effect, ...],
) -> NamedCurves | None:
    """Return the curves with the laws of a diagnosis, the usual one alone where it names nothing; None as above.

    Raises UsageProblem when an effect is not in the library.
    """
    if document.fitted is None:
        return None
    laws = [_law("usual model", "usual", document.fitted, library)]
    if document.final is not None:
        known = set(laws[0].model.names)
        own = _law("", "named", document.final, library)
        more = [name for name in own.model.names if name not in known]
        if more:  # models that differ in sensors' faults alone are one law
            laws.append(replace(own, name=" + ".join(more)))
    if len(laws) > 1 and len(document.named) == 1:
        models = {suspect.effect: suspect.model for suspect in document.suspects}
        laws += [
            _law(name, "rival", model, library) for name in document.rivals if (model := models.get(name))
        ]
    try:
        return NamedCurves(names, decay_curves(decays, laws[: 2 + MOST_RIVALS]))
    except NotIdentifiable:
        return None


def _law(name: str, role: Role, model: ModelFile, library: tuple[Effect, ...]) -> Law:
    known = known_model(model, "the diagnosis", library)
    return Law.known(name, role, known.model, known.values)
