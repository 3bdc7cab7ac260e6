"""Confirmation by curves: the effects that their evidence names, and the errors of their predictions."""

from dataclasses import dataclass

from identify.curves.held_out import HeldOut
from identify.evidence import Evidence
from identify.model.model import Term


@dataclass(frozen=True, eq=False)
class ConfirmedEffect:
    """An effect that predicts: the error of what it `explains` ("frequency" or "loss") falls from `before` to `after` %.

    With it `better` of the held-out `parts` are predicted better. `evidence` has the nats of it and of other laws; `rivals`
    are those that are not distinguishable from it.
    """

    term: Term
    strength: float
    explains: str
    before: float
    after: float
    better: int
    parts: int
    evidence: Evidence
    rivals: tuple[str, ...] = ()

    @property
    def nats(self) -> float:
        """Its evidence against the model without it."""
        return self.evidence.nats[self.name]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name


@dataclass(frozen=True, eq=False)
class Confirmation:
    """The effects that curves confirm.

    `effects` in the order in which they were taken. `usual` and `found` are the errors of the model as given and with
    the effects, for each part that was left out; `one_record` says that these are parts of a record, not releases.
    `asked` is the evidence in the order in which it was asked for. `laws` are the effects that were tried;
    `releases` are the places, among those that were given, of those that have a curve.
    """

    effects: tuple[ConfirmedEffect, ...]
    usual: HeldOut
    found: HeldOut
    one_record: bool
    asked: tuple[Evidence, ...] = ()
    laws: tuple[str, ...] = ()
    releases: tuple[int, ...] = ()

    @property
    def undecided(self) -> dict[str, tuple[str, ...]]:
        """By "frequency" or "loss" the names of laws that explain it and that are not distinguishable."""
        return {one.explains: one.names for one in self.asked if one.verdict != "named"}

    def has_law(self, name: str) -> bool:
        """Check whether the curves can show an effect at all."""
        return name in self.laws

    @property
    def mentioned(self) -> set[str]:
        """The names of all effects that explain something: confirmed ones, their rivals, and what is undecided."""
        named = {name for effect in self.effects for name in (effect.name, *effect.rivals)}
        return named.union(*self.undecided.values())

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the confirmed effects."""
        return tuple(effect.name for effect in self.effects)

    @property
    def parts(self) -> int:
        """Number of parts that were left out and predicted."""
        return len(self.found.predicted)

    @property
    def better(self) -> int:
        """On how many parts the prediction with the effects is the better one."""
        return self.found.better(self.usual, "motion")
