"""What curves confirm: effects that foretell what they were not fitted to, and what stays undecided."""

from dataclasses import dataclass, field

from identify.curves.decay_curve import DecayCurve
from identify.curves.held_out import HeldOut
from identify.model.model import Term

MOST_RIVALS = 3
"""Rivals of an effect; where more laws foretell as well, none of them is the name."""

RANGE = 2.5
"""Largest over smallest amplitude, over all releases, from which on laws of amplitude can be told at all."""


@dataclass(frozen=True, eq=False)
class ConfirmedEffect:
    """An effect that foretells: the error of what it `explains` ("frequency" or "loss") falls from `before` to `after` %.

    `better` of `parts` left out were foretold better with it. `rivals` foretell nearly as well, or lead where other
    cycles are drawn. It, or one that foretells nearly as well, leads in `leads` of `resamplings` of the cycles. `alone`
    are the releases that name it each by itself, where all together do not (0: they do; see `release_by_release`).
    """

    term: Term
    strength: float
    inner: dict[str, float]
    explains: str
    before: float
    after: float
    better: int
    parts: int
    rivals: tuple[str, ...]
    leads: int
    resamplings: int
    alone: int = 0

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.term.effect.name

    @property
    def values(self) -> dict[str, float]:
        """Starting values of its parameters by unknown's name."""
        return self.term.by_name(self.inner | {self.term.effect.strength.name: self.strength})


@dataclass(frozen=True, eq=False)
class Confirmation:
    """What curves confirm.

    `effects` in the order in which they were taken. `usual` and `found` are the errors of the model as given and with
    the effects, for each part that was left out; `one_record` says that these are halves of a record, not releases.
    `undecided` maps "frequency" or "loss" to the names of laws that explain it and that these releases do not part
    from a drift in time, or from one another; `unstable` says of the latter in how many resamplings each leads ("": none).
    `laws` are the effects that were tried; `linear_strengths` those of the model's own forces with the effects, by
    unknown's name. `releases` are the places, among those that were given, of those that have a curve.
    """

    curves: tuple[DecayCurve, ...]
    effects: tuple[ConfirmedEffect, ...]
    usual: HeldOut
    found: HeldOut
    one_record: bool
    undecided: dict[str, tuple[str, ...]] = field(default_factory=dict)
    laws: tuple[str, ...] = ()
    linear_strengths: dict[str, float] = field(default_factory=dict)
    releases: tuple[int, ...] = ()
    unstable: dict[str, dict[str, int]] = field(default_factory=dict)

    def has_law(self, name: str) -> bool:
        """Whether the curves can show an effect at all."""
        return name in self.laws

    @property
    def beats(self) -> bool:
        """Whether the amplitude of some release beats."""
        return any(curve.beats for curve in self.curves)

    @property
    def driven(self) -> bool:
        """Whether some release does not die away."""
        return any(curve.driven for curve in self.curves)

    @property
    def span(self) -> float:
        """Largest amplitude over the smallest, over all curves; infinite where there is none."""
        sizes = [size for curve in self.curves for size in (curve.amplitude.max(), curve.amplitude.min())]
        return float(max(sizes) / min(sizes)) if sizes else float("inf")

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
        """Number of parts that were left out and foretold."""
        return len(self.found.foretold)

    @property
    def better(self) -> int:
        """On how many parts the prediction with the effects is the better one."""
        return self.found.better(self.usual, "motion")
