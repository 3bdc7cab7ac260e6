"""The evidence for several effects, and the one table that turns it into a verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from identify.effects.effect import Effect
from identify.effects.force_effect import ForceEffect
from identify.priors import DOUBT, MOST_ALIKE

Decided = Literal["nothing", "named", "no name", "may drift", "too many"]


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


def nothing(nats: Sequence[float]) -> float:
    """Return the probability that none of several effects is there, from the evidence for each (nats).

    None is as probable as all together to begin with, and these as one another.
    """
    if not nats:
        return 1.0
    most = max(0.0, *nats)
    none = len(nats) * float(np.exp(-most))
    return none / (none + float(np.sum(np.exp(np.array(nats) - most))))


def decide(
    nats: Mapping[str, float],
    effects: Mapping[str, Effect],
    *,
    unnamed: float = -np.inf,
    beside: float = -np.inf,
    drift_weighed: bool = False,
) -> Evidence:
    """Decide what the evidence for several laws names: the one table of verdicts.

    None is as probable as all laws together to begin with, and these as one another. The laws that are not distinguishable
    are the likeliest ones that leave out DOUBT of the probability at most. `unnamed` is the evidence for a law without a
    name in their place, as probable as each to begin with, and `beside` that for one beside the leader. Laws of time stand
    for any drift unless a drift is part of every hypothesis (`drift_weighed`).

    | probability | verdict |
    |---|---|
    | of none above DOUBT | nothing |
    | of a law without a name in their place above DOUBT, or of none beside the leader below DOUBT | no name |
    | of the laws of time above DOUBT, if it is a law | may drift |
    | of any MOST_ALIKE laws below 1 - DOUBT | too many |
    | else | named: those that are not distinguishable, the likeliest first |
    """
    places = list(effects)
    order = sorted(
        nats, key=lambda name: (-round(nats[name], 1), places.index(name))
    )  # of equal ones the library's first
    if nothing(tuple(nats.values())) > DOUBT:
        return Evidence(dict(nats), "nothing")
    most = max(nats.values())
    weight = {name: float(np.exp(nats[name] - most)) for name in order}
    total = sum(weight.values())
    above = np.cumsum([weight[name] for name in order])
    near = tuple(order[: 1 + int(np.searchsorted(above, (1.0 - DOUBT) * total))])
    if np.exp(unnamed - most) > DOUBT * (total + np.exp(unnamed - most)) or nothing((beside,)) < DOUBT:
        return Evidence(dict(nats), "no name", near)
    if not drift_weighed and sum(weight[name] for name in order if effects[name].of_time) > DOUBT * total:
        return Evidence(dict(nats), "may drift", near)
    return Evidence(dict(nats), "named" if len(near) <= MOST_ALIKE else "too many", near)


def complexity(effect: Effect) -> int:
    """Count an effect's own constants, and add how rare it is: of those that are not distinguishable the least leads.

    One that may be the whole of a linear law, as gravity of an angle's spring, has no strength of its own.
    """
    own_strength = not (isinstance(effect, ForceEffect) and effect.may_be_all_of is not None)
    return own_strength + len(effect.inner) + effect.rarity
