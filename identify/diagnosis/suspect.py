"""A suspect: one effect that a model may lack, with the evidence for it."""

from dataclasses import dataclass

from identify.curves.confirmation import ConfirmedEffect
from identify.effects.effect import Effect, Kind
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.model.model import Term


@dataclass(frozen=True, eq=False)
class Suspect:
    """One effect that the model may lack.

    `error_after` is the reduced chi-square of the model refitted with it, `parameters` what that refit found.
    `stated` is the `fit` with the standard errors to state.
    `evidence` is in nats: how much better than by chance the refit explains the readings. `p_value` is the probability
    that chance gives any suspect of the library as good a reason, nan where no chance was drawn; `claimed` says that the
    effect is claimed. `rivals` are claimed effects whose evidence is as good: this record does not tell them apart.
    `held_out_gain` is the drop of chi-square on cycles that were not fitted, None when it was not asked. `plausible` is
    False where another effect is the better name for the same force. `confirmed` says what the effect foretells of
    readings that it was not fitted to, None where that was not asked or it foretells nothing.
    """

    effect: Effect
    term: Term
    error_after: float
    evidence: float
    p_value: float
    claimed: bool
    parameters: dict[str, Estimate]
    fit: Fit
    stated: Fit
    rivals: tuple[str, ...] = ()
    held_out_gain: float | None = None
    plausible: bool = True
    confirmed: ConfirmedEffect | None = None

    @property
    def kind(self) -> Kind:
        """physics or sensor."""
        return self.effect.kind

    @property
    def confusable_with(self) -> tuple[str, ...]:
        """Effects that this record does not tell from it, and effects that it is known to be mistaken for."""
        return (*self.rivals, *(name for name in self.effect.confusable_with if name not in self.rivals))
