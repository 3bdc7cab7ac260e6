"""Which law leads: of those that leave nearly as little the simplest, none where a law of time leaves hardly more."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from identify.curves.averaged_law import AveragedLaw
from identify.effects.effect import Effect

NEARLY = 0.8
"""Laws that remove this share of what the best removes are not told apart from it."""

DRIFT_NEARLY = 0.7
"""The same for a law of time: what may be a drift is no law of the amplitude."""

CLEARLY = 1.0 / 3.0
"""Share of the error of every law without inner parameters below which a law with some is taken: it can bend to much."""


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
) -> Choice:
    """Return which of the `good` columns leads, from the error that each column leaves and the error before, in %.

    Of those that leave nearly as little the simplest does; none where a law of time leaves hardly more.
    """
    removed = {c: before - left[c] for c in left}
    best = max(removed[c] for c in good)
    near = central([c for c in good if removed[c] >= NEARLY * best])
    drifts = [c for c in left if laws[c].term.effect.of_time and removed[c] >= DRIFT_NEARLY * best]
    if drifts:
        return Choice(None, _names(laws, (*near, *drifts)), _names(laws, drifts))
    plain = [c for c in good if not laws[c].term.effect.inner]
    if plain and min(left[c] for c in near) > CLEARLY * min(left[c] for c in plain):
        near = [*near, min(plain, key=lambda c: left[c])]
    elif not plain and min(left[c] for c in near) > CLEARLY * before:
        near = []
    if not near:
        return Choice(None, (), ())
    lead = min(near, key=lambda c: (complexity(laws[c].term.effect), -removed[c]))
    return Choice(lead, _names(laws, (lead, *near)), ())


def _names(laws: Sequence[AveragedLaw], columns: Sequence[int]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(laws[c].name for c in columns))


def complexity(effect: Effect) -> int:
    """Return how much an effect can bend, and how rare it is: of effects that are not told apart the least leads."""
    return len(effect.inner) + effect.rarity
