"""Curves of sessions with the laws of their diagnosis, made from the records and the document whenever they are drawn."""

from dataclasses import dataclass

from identify.curves.laid_over import DecayCurves, decay_curves
from identify.diagnosis.found_laws import laws_of_models
from identify.effects.effect import Effect
from identify.errors import NotIdentifiable
from identify.model.model import Model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument
from station.results.models import ModelFile, known_model


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
    usual = _known(document.fitted, library)
    named = None if document.final is None else _known(document.final, library)
    try:
        laws = laws_of_models(decays, usual, named, tuple(document.rivals), library)
        return NamedCurves(names, decay_curves(decays, laws))
    except NotIdentifiable:
        return None


def _known(model: ModelFile, library: tuple[Effect, ...]) -> tuple[Model, dict[str, float]]:
    known = known_model(model, "the diagnosis", library)
    return known.model, known.values
