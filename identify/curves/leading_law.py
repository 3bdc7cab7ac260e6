"""Which law leads: of those that leave nearly as little the simplest, none where a law of time leaves hardly more.

In one record any law of the amplitude is also one of time, by their shapes alone. In several releases an amplitude comes at
several times.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from identify.curves.averaged_law import AveragedLaw
from identify.effects.effect import Effect

NEARLY = 0.8
"""Laws that remove this share of what the best removes are not told apart from it."""

DRIFT_NEARLY = 0.7
"""The same for a law of time: what may be a drift is no law of the amplitude."""

DRIFT_LEAVES = 3.0
"""Multiple of what the best law of the amplitude leaves up to which a law of time may be behind it, in one record."""

DRIFT_LEAVES_RELEASES = 1.5
"""The same in several releases."""

CLEARLY = 1.0 / 3.0
"""Share of the error of every law without inner parameters below which a law with some is taken: it can bend to much."""


WORTH = 0.5
"""Error, in % of the motion, that an effect must remove to be worth a name; what is below is not told apart."""


@dataclass(frozen=True)
class Choice:
    """The column that leads, None where none does, the names of its rivals, and of laws of time that may be behind."""

    lead: int | None
    names: tuple[str, ...]
    drifts: tuple[str, ...]

    @property
    def rivals(self) -> tuple[str, ...]:
        """The names beside the leader's."""
        return self.names[1:] if self.lead is not None else ()


def choose(
    laws: Sequence[AveragedLaw],
    good: Sequence[int],
    central: Callable[[list[int]], list[int]],
    left: Mapping[int, float],
    before: float,
    *,
    one_record: bool,
) -> Choice:
    """Return which of the `good` columns leads, from the error that each column leaves and the error before, in %.

    Of those that leave nearly as little the simplest does, of equally simple ones the first whose error is not worth
    telling from the least; none where a law of time leaves hardly more.
    """
    removed = {c: before - left[c] for c in left}
    best = max(removed[c] for c in good)
    near = central(
        [c for c in sorted(good) if removed[c] >= NEARLY * best]
    )  # some laws are alike to the last bit
    drifts = _drifts(laws, good, left, before, DRIFT_LEAVES if one_record else DRIFT_LEAVES_RELEASES)
    if drifts:
        return Choice(None, _names(laws, (*near, *drifts)), _names(laws, drifts))
    near = [c for c in near if not laws[c].term.effect.of_time]
    plain = [c for c in good if not laws[c].term.effect.inner]
    if not near:
        return Choice(None, (), ())
    may_lead, bent = near, min(left[c] for c in near)
    if plain and bent > CLEARLY * min(left[c] for c in plain):
        may_lead = [c for c in near if c in plain] or [min(plain, key=lambda c: left[c])]
    elif not plain and bent > CLEARLY * before:
        return Choice(None, (), ())
    simple = min(complexity(laws[c].term.effect) for c in may_lead)
    may_lead = [c for c in may_lead if complexity(laws[c].term.effect) == simple]
    least = min(left[c] for c in may_lead)
    lead = min(c for c in may_lead if left[c] <= least + WORTH)  # the library's order, so that repeats agree
    return Choice(lead, _names(laws, (lead, *near)), ())


def _drifts(
    laws: Sequence[AveragedLaw], good: Sequence[int], left: Mapping[int, float], before: float, leaves: float
) -> list[int]:
    """Return the laws of time that remove nearly as much as the best law of the amplitude and leave at most a multiple."""
    most = max(before - left[c] for c in good)
    ofamplitude = [left[c] for c in good if not laws[c].term.effect.of_time]
    least = max(min(ofamplitude, default=before), WORTH)
    return [
        c
        for c in sorted(left)
        if laws[c].term.effect.of_time
        and before - left[c] >= DRIFT_NEARLY * most
        and left[c] <= leaves * least
    ]


def _names(laws: Sequence[AveragedLaw], columns: Sequence[int]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(laws[c].name for c in columns))


def complexity(effect: Effect) -> int:
    """Return how much an effect can bend, and how rare it is: of effects that are not told apart the least leads."""
    return len(effect.inner) + effect.rarity
