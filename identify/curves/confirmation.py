"""What curves confirm: the evidence for each law, what it decides, and the effects that are named by it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from identify.curves.decay_curve import DecayCurve
from identify.curves.held_out import HeldOut
from identify.curves.priors import DOUBT, MOST_ALIKE
from identify.effects.effect import Effect
from identify.effects.force_effect import ForceEffect
from identify.model.model import Term

Decided = Literal["nothing", "named", "may drift", "too many"]


@dataclass(frozen=True)
class Evidence:
    """The evidence for one more law: `nats` of each against the model without it, by name, and what it decides.

    `names` are those that are not distinguishable, the one that leads first; `explains` is "frequency" or "loss".
    """

    nats: dict[str, float]
    verdict: Decided
    names: tuple[str, ...] = ()
    explains: str = ""

    @property
    def lead(self) -> str | None:
        """The law that leads, named or not; None where nothing is more likely than any."""
        return self.names[0] if self.names else None

    def led_by(self, name: str) -> "Evidence":
        """Return the same evidence with another of the names that are not distinguishable in the lead."""
        return replace(self, names=(name, *(other for other in self.names if other != name)))

    def of(self, explains: str) -> "Evidence":
        """Return the same evidence of what its leader explains."""
        return replace(self, explains=explains)


def decide(nats: Mapping[str, float], effects: Mapping[str, Effect]) -> Evidence:
    """Decide what the evidence for several laws names: the one table of verdicts.

    None is as probable as all laws together to begin with, and these as one another. The laws that are not distinguishable
    are the likeliest ones that leave out DOUBT of the probability at most.

    | probability | verdict |
    |---|---|
    | of none above DOUBT | nothing |
    | of the laws of time above DOUBT, if it is a law | may drift |
    | of any MOST_ALIKE laws below 1 - DOUBT | too many |
    | else | named: those that are not distinguishable, the likeliest first |
    """
    places = list(effects)
    order = sorted(
        nats, key=lambda name: (-round(nats[name], 1), places.index(name))
    )  # of equal ones the library's first
    most = max((0.0, *nats.values()))
    weight = {name: float(np.exp(nats[name] - most)) for name in order}
    total = sum(weight.values())
    none = len(order) * float(np.exp(-most))
    if none > DOUBT * (total + none):
        return Evidence(dict(nats), "nothing")
    above = np.cumsum([weight[name] for name in order])
    near = tuple(order[: 1 + int(np.searchsorted(above, (1.0 - DOUBT) * total))])
    if sum(weight[name] for name in order if effects[name].of_time) > DOUBT * total:
        return Evidence(dict(nats), "may drift", near)
    return Evidence(dict(nats), "named" if len(near) <= MOST_ALIKE else "too many", near)


def complexity(effect: Effect) -> int:
    """Count an effect's own constants, and add how rare it is: of those that are not distinguishable the least leads.

    One that may be the whole of a linear law, as gravity of an angle's spring, has no strength of its own.
    """
    own_strength = not (isinstance(effect, ForceEffect) and effect.may_be_all_of is not None)
    return own_strength + len(effect.inner) + effect.rarity


@dataclass(frozen=True, eq=False)
class ConfirmedEffect:
    """An effect that predicts: the error of what it `explains` ("frequency" or "loss") falls from `before` to `after` %.

    `better` of `parts` left out are predicted better with it. `evidence` has the nats of it and of its rivals.
    """

    term: Term
    strength: float
    inner: dict[str, float]
    explains: str
    before: float
    after: float
    better: int
    parts: int
    evidence: Evidence

    @property
    def rivals(self) -> tuple[str, ...]:
        """The names of the laws that are not distinguishable from it."""
        return self.evidence.names[1:]

    @property
    def nats(self) -> float:
        """Its evidence against the model without it."""
        return self.evidence.nats[self.name]

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
    the effects, for each part that was left out; `one_record` says that these are parts of a record, not releases.
    `asked` is the evidence in the order in which it was asked for. `laws` are the effects that were tried;
    `linear_strengths` those of the model's own forces with the effects, by unknown's name. `releases` are the places,
    among those that were given, of those that have a curve.
    """

    curves: tuple[DecayCurve, ...]
    effects: tuple[ConfirmedEffect, ...]
    usual: HeldOut
    found: HeldOut
    one_record: bool
    asked: tuple[Evidence, ...] = ()
    laws: tuple[str, ...] = ()
    linear_strengths: dict[str, float] = field(default_factory=dict)
    releases: tuple[int, ...] = ()

    @property
    def undecided(self) -> dict[str, tuple[str, ...]]:
        """By "frequency" or "loss" the names of laws that explain it and that are not distinguishable."""
        return {one.explains: one.names for one in self.asked if one.verdict != "named"}

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
