"""The fits behind a diagnosis: of the model, and with each of the best suspects; what the pictures of forces need."""

from dataclasses import dataclass

from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.effects.effect import Effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit, fit
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.diagnosis_document import DiagnosisDocument
from station.results.models import ModelFile, known_model, starting_values

MOST = 3


@dataclass(frozen=True, eq=False)
class DiagnosisFits:
    """A diagnosis with its fits, and the release of the largest amplitude.

    `index` is the place of that release among the fits' windows; `best` the first suspects, each refitted.
    """

    document: DiagnosisDocument
    prepared: PreparedDecay
    index: int
    base: Fit
    best: tuple[tuple[Term, Fit], ...]

    def missing_force(self) -> ForceMap:
        """Return the force that the model lacks, by amplitude and phase of the cycle."""
        return force_map(self.prepared, force_left(self.prepared, self.base))

    def added_forces(self) -> tuple[tuple[Term, ForceMap], ...]:
        """Return the force that each of the best suspects would add."""
        return tuple(
            (term, force_map(self.prepared, force_added(self.prepared, self.base, found, term, self.index)))
            for term, found in self.best
        )


def refitted(
    document: DiagnosisDocument, prepared: PreparedDecay, library: tuple[Effect, ...], most: int = MOST
) -> DiagnosisFits | None:
    """Return the fits of a diagnosis that was kept, found again from its values; None where it holds none.

    Raises UsageProblem when an effect is not in the library.
    """
    if document.fitted is None:
        return None

    first = known_model(document.fitted, "the diagnosis", library)
    base = fit_baseline((prepared,), first.model, starting_values(first, (prepared,))).fit
    best = tuple(_refitted(s.model, base, prepared, library) for s in document.suspects[:most] if s.model)
    return DiagnosisFits(document, prepared, 0, base, best)


def _refitted(
    model: ModelFile, base: Fit, prepared: PreparedDecay, library: tuple[Effect, ...]
) -> tuple[Term, Fit]:
    known = known_model(model, "the diagnosis", library)
    start = starting_values(known, (prepared,))
    return known.model.terms[-1], fit(known.model, base.windows, start, base.frequency)
