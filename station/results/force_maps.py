"""The force that a model lacks, and what the best suspects would add, by amplitude and phase of the cycle."""

from collections.abc import Iterable

from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.effects.effect import Effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit, fit
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument
from station.results.models import ModelFile, known_model, starting_values

MOST = 3

NamedMaps = tuple[tuple[str, ForceMap], ...]


def force_maps(
    prepared: PreparedDecay, base: Fit, best: Iterable[tuple[Term, Fit]], index: int = 0
) -> NamedMaps:
    """Map the force that the model `base` lacks in the release `index` among its windows, and what each of `best` adds."""
    lacks = ("what the model lacks", force_map(prepared, force_left(prepared, base)))
    adds = (
        (term.effect.name, force_map(prepared, force_added(prepared, base, found, term, index)))
        for term, found in best
    )
    return (lacks, *adds)


def kept_force_maps(
    document: DiagnosisDocument, prepared: PreparedDecay, library: tuple[Effect, ...]
) -> NamedMaps:
    """Map the forces of a diagnosis that was kept, its fits found again from their values; none where it holds none.

    Raises UsageProblem when an effect is not in the library.
    """
    models = [suspect.model for suspect in document.suspects[:MOST] if suspect.model]
    if document.fitted is None or not models:
        return ()
    first = known_model(document.fitted, "the diagnosis", library)
    base = fit_baseline((prepared,), first.model, starting_values(first, (prepared,))).fit
    return force_maps(prepared, base, [_refitted(model, base, prepared, library) for model in models])


def _refitted(
    model: ModelFile, base: Fit, prepared: PreparedDecay, library: tuple[Effect, ...]
) -> tuple[Term, Fit]:
    known = known_model(model, "the diagnosis", library)
    start = starting_values(known, (prepared,))
    return known.model.terms[-1], fit(known.model, base.windows, start, base.frequency)
