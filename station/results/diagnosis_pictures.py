"""What the pictures of a diagnosis are drawn from: curves with its laws, and maps of forces, made from the records."""

from collections.abc import Iterable
from dataclasses import replace

from identify.curves.laid_over import DecayCurves, Law, Role, decay_curves
from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.effects.effect import Effect
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit, fit
from identify.judging.verdict import MOST_RIVALS
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument
from station.results.models import ModelFile, known_model

MOST = 3

NamedMaps = tuple[tuple[str, ForceMap], ...]
NamedCurves = tuple[tuple[str, ...], DecayCurves]
"""The names of the sessions that were given, by the releases' places, and the curves of their releases."""


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
        return names, decay_curves(decays, laws[: 2 + MOST_RIVALS])
    except NotIdentifiable:
        return None


def _law(name: str, role: Role, model: ModelFile, library: tuple[Effect, ...]) -> Law:
    known = known_model(model, "the diagnosis", library)
    return Law.known(name, role, known.model, known.values)


def force_maps(
    prepared: PreparedDecay, base: Fit, best: Iterable[tuple[Term, Fit]], index: int = 0
) -> NamedMaps:
    """Map the force that the model `base` lacks in the release `index` among its windows, and what each of `best` adds."""
    lacks = ("what the model lacks", force_map(prepared, force_left(prepared, base, index)))
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
    base = fit_baseline((prepared,), first.model, first.start((prepared,))).fit
    return force_maps(prepared, base, [refitted(model, base, prepared, library) for model in models])


def refitted(
    model: ModelFile, base: Fit, prepared: PreparedDecay, library: tuple[Effect, ...]
) -> tuple[Term, Fit]:
    """Fit a suspect's model near its values, which are not lost to another minimum; return its last term, and the fit."""
    known = known_model(model, "the diagnosis", library)
    start = known.start((prepared,)) or {}
    return known.model.terms[-1], fit(known.model, base.windows, start, base.frequency, near=True)
