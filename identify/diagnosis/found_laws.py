"""The laws that a diagnosis leaves to be looked at: the usual model, the named one, and the rivals of what is named."""

from collections.abc import Sequence

from identify.curves.laid_over import Law, rival_law, usual_law
from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.suspects import candidate_terms
from identify.effects.effect import Effect
from identify.fitting.segments import prepared_of
from identify.free_decay import FreeDecay
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

MOST_RIVALS = 2


def found_laws(
    decays: FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay], found: Diagnosis
) -> tuple[Law, ...]:
    """Return the laws of a diagnosis of one release or some, to be laid over their curves by `decay_curves`.

    Raises NotIdentifiable where no release has a curve.
    """
    fits = (found.baseline.fit, found.final)
    usual, final = (
        (fit.model, {name: estimate.value for name, estimate in fit.parameters.items()}) for fit in fits
    )
    rivals = found.suspects[0].rivals if found.named else ()
    return laws_of_models(prepared_of(decays), usual, final if found.named else None, rivals, found.library)


def laws_of_models(
    decays: tuple[PreparedDecay, ...],
    usual: tuple[Model, dict[str, float]],
    named: tuple[Model, dict[str, float]] | None,
    rivals: tuple[str, ...],
    library: tuple[Effect, ...],
) -> tuple[Law, ...]:
    """Return the laws of a usual and of a named model, each with its values by unknown's name, and of the rivals.

    The usual model's strengths are fitted to the curves, since a free run that goes astray would show it as worse than it
    is; the named model's are those given. A rival stands in for the first effect that the named model has beyond the usual
    one, all strengths fitted to the curves. Models that differ in sensors' faults alone are one law. Raises
    NotIdentifiable where no release has a curve.
    """
    laws = [usual_law(decays, *usual)]
    if named is None:
        return tuple(laws)
    own = Law.of("", "named", *named)
    more = [name for name in own.model.names if name not in laws[0].model]
    if not more:
        return tuple(laws)
    laws.append(Law(" + ".join(more), "named", own.model, own.values))
    terms = {term.effect.name: term for term in reversed(_forces(usual[0], library, decays))}
    for name in [n for n in rivals if n in terms and n not in own.model][:MOST_RIVALS]:
        rival = rival_law(decays, own, more[0], terms[name])
        if rival is not None:
            laws.append(rival)
    return tuple(laws)


def _forces(model: Model, library: tuple[Effect, ...], decays: tuple[PreparedDecay, ...]) -> tuple[Term, ...]:
    return tuple(term for term in candidate_terms(model, library, decays[0].window) if term.is_force)
