"""A suspect: one effect that a model may lack, with the evidence for it."""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property

from identify.curves.confirmation import ConfirmedEffect
from identify.effects.effect import Effect, Kind
from identify.estimate import Estimate
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit
from identify.model.model import Term


@dataclass(frozen=True, eq=False)
class Suspect:
    """One effect that the model may lack.

    `fit` is the model refitted with it, judged against the `baseline`. The residual of the final model with it is
    `error_after`, reduced chi-square, and `motion_after`, % of the motion, None for a fault that every fit corrects.
    Its parameters are those of `last`: of the fit of all that is named where it is among them, else of its own; `corrected`
    are those of a fault that every fit corrects, None of all else.
    `evidence` is in nats: how much more probable the readings are with it. `claimed` says that the effect is claimed.
    `rivals` are claimed effects whose evidence is as good: this record does not distinguish them.
    `plausible` is False where its values make it the same force as another effect. `confirmed` says what the effect
    predicts of readings that it was not fitted to, None where that was not asked or it predicts nothing.
    """

    effect: Effect
    term: Term
    error_after: float
    motion_after: float | None
    evidence: float
    claimed: bool
    baseline: Baseline
    fit: Fit
    last: Fit
    corrected: dict[str, Estimate] | None = None
    rivals: tuple[str, ...] = ()
    plausible: bool = True
    confirmed: ConfirmedEffect | None = None

    @cached_property
    def stated(self) -> Fit:
        """The fit with the standard errors to state; computed when first asked for, because that is slow."""
        return self.baseline.stated(self.fit, drifts=False)

    @cached_property
    def parameters(self) -> dict[str, Estimate]:
        """The parameters of the effect by their own names, with the standard errors to state."""
        if self.corrected is not None:
            return self.corrected
        last = self.stated if self.last is self.fit else self.baseline.stated(self.last)
        return last.quoted(self.term)

    @property
    def strength_known(self) -> bool:
        """Whether its parameters mean anything: where the strength is below its error, the others are arbitrary."""
        strength = self.parameters.get(self.effect.strength.name)
        if strength is None or len(self.effect.parameters) == 1:
            return True
        return strength.std <= abs(strength.value)

    @property
    def kind(self) -> Kind:
        """physics or sensor."""
        return self.effect.kind

    @property
    def confusable_with(self) -> tuple[str, ...]:
        """Effects that this record does not distinguish from it, and effects that it is known to be mistaken for."""
        return (*self.rivals, *(name for name in self.effect.confusable_with if name not in self.rivals))


def kinds_alike(top: Suspect, suspects: Collection[Suspect]) -> set[Kind]:
    """Return the kinds of a suspect and of the plausible ones that are not distinguishable from it."""
    return {one.kind for one in suspects if one is top or (one.plausible and one.effect.name in top.rivals)}
