"""Release by release: what single releases name each by themselves, and what foretells the others, is named of all.

Over several releases errors are compared by their rms, which the worst foretold release decides. Where one of them shows
something else besides (a spring that hardens at amplitudes that only it has), that hides from all together what the
others show. A law is then still confirmed that is named within single releases, each by itself, and that foretells the
releases from one another: it halves the median error, and makes none of them worse.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from identify.curves.confirm import MOST_PARTS, SHARE, confirmed, search_of
from identify.curves.confirmation import RANGE, Confirmation, ConfirmedEffect
from identify.curves.curve_search import CurveSearch
from identify.curves.held_out import HeldOut
from identify.curves.leading_law import WORTH
from identify.effects.effect import Scales
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

_FEWEST = 2
"""Releases that must name an effect each by itself."""

_CHANNEL = {"frequency": "phase", "loss": "envelope"}


def confirm_releases(
    decays: Sequence[PreparedDecay],
    model: Model,
    known: dict[str, float],
    terms: tuple[Term, ...],
    scales: Scales,
) -> Confirmation | None:
    """Return what the curves of some releases confirm beyond a model, together or, where that is nothing, each by itself.

    `known` has the model's parameters by unknown's name, `terms` are the candidates. None where the curves are too short to
    tell.
    """
    begun = search_of(decays, model, known, terms, scales)
    if begun is None:
        return None
    search, places = begun
    found = confirmed(search, places)
    if found.effects or found.one_record or search.span < RANGE:
        return found
    for own in _agreed(search):
        law = _foretelling(search, found.usual, own[0].name)
        if law is not None:
            what = own[0].explains
            others = {kind: names for kind, names in found.undecided.items() if kind != what}
            effect = _of_all(search, found.usual, law, own)
            return replace(found, effects=(effect,), found=law.held, undecided=others)
    return found


def _agreed(search: CurveSearch) -> list[list[ConfirmedEffect]]:
    """Return each effect that releases name each by itself and agree in, as those releases confirm it.

    Two releases at least must name it, and it must be named, or be a rival of the name, in most of those that can tell;
    none may name another for the same kind. Asked are no more than it takes to see that most name nothing.
    """
    able = [one for one in map(search.alone, range(len(search.decays))) if len(one.parts) > 1]
    able = [one for one in able if one.span >= RANGE]
    told: list[Confirmation] = []
    for one in able:
        told.append(confirmed(one))
        if sum(not c.effects for c in told) > (1.0 - MOST_PARTS) * len(able):
            return []
    agreed = []
    for name in dict.fromkeys(name for one in told for name in one.names):
        own = [effect for one in told for effect in one.effects if effect.name == name]
        named = [(e.name, *e.rivals) for one in told for e in one.effects if e.explains == own[0].explains]
        most = len(named) >= max(_FEWEST, MOST_PARTS * len(able))
        if len(own) >= _FEWEST and most and all(name in alike for alike in named):
            agreed.append(own)
    return agreed


@dataclass(frozen=True, eq=False)
class _Foretelling:
    """A column and its errors with all releases, each left out in turn."""

    column: int
    held: HeldOut


def _foretelling(search: CurveSearch, usual: HeldOut, name: str) -> _Foretelling | None:
    """Return the best column of an effect if it foretells the releases from one another."""
    base = tuple(range(len(search.base)))
    rows = search.corrected(base, usual)
    own = [c for c, law in enumerate(search.regression.laws) if law.name == name and c >= len(base)]
    best = min(own, key=lambda c: search.hold_out((*base, c), rows).typical("motion"))
    held, _ = search.settled((*base, best), rows)
    good = search.plausible(best, held) and _foretells(usual, held)
    return _Foretelling(best, held) if good else None


def _foretells(usual: HeldOut, held: HeldOut) -> bool:
    """Whether a law halves the median error, betters most releases, and makes none worse."""
    before, after = usual.typical("motion"), held.typical("motion")
    spoilt = any(
        mine.motion > theirs.motion + WORTH
        for mine, theirs in zip(held.foretold, usual.foretold, strict=True)
    )
    enough = before - after >= max(SHARE * before, WORTH)
    return enough and not spoilt and held.better(usual, "motion") >= MOST_PARTS * len(held.foretold)


def _of_all(
    search: CurveSearch, usual: HeldOut, law: _Foretelling, own: Sequence[ConfirmedEffect]
) -> ConfirmedEffect:
    """Return the effect with its strength over all releases, and what the single ones say of its rivals."""
    chosen = search.regression.laws[law.column]
    channel = _CHANNEL[own[0].explains]
    return replace(
        own[0],
        term=chosen.term,
        strength=float(law.held.strengths.shared[-1]),
        inner=chosen.inner,
        before=usual.typical(channel),
        after=law.held.typical(channel),
        better=law.held.better(usual, channel),
        parts=len(law.held.foretold),
        rivals=tuple(dict.fromkeys(name for effect in own for name in effect.rivals)),
        leads=sum(effect.leads for effect in own),
        resamplings=sum(effect.resamplings for effect in own),
        alone=len(own),
    )
