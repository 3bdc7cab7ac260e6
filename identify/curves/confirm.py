"""The search for effects that foretell what they were not fitted to.

Laws are added one at a time, to the kind of error (of the phase, or of the envelope) that is worst foretold. A law is
taken only if it removes a good share of that error, on most of the parts that were left out, and spoils nothing else.
Of laws that do so nearly as well the simplest leads, and the others are its rivals. A frequency that may move with time
as well as with the amplitude names nothing.
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

from identify.curves.confirmation import MOST_RIVALS, RANGE, Confirmation, ConfirmedEffect
from identify.curves.curve_regression import Rows
from identify.curves.curve_search import CurveSearch
from identify.curves.held_out import HeldOut
from identify.curves.isolated_mode import IsolatedMode
from identify.curves.leading_law import WORTH, choose
from identify.curves.stability import Contender, leaders
from identify.effects.effect import Scales
from identify.errors import NotIdentifiable
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

SHARE = 0.5
"""Share of an error that an effect must remove to be worth a name."""

MOST_PARTS = 0.66
"""Share of the parts left out that an effect must foretell better."""

SECOND_WORTH = 2.0
"""Error, in % of the motion, that a second effect must remove where another has removed its part."""

STABLE = 0.5
"""Share of the resamplings in which an effect, or one that it is not told apart from, must lead to be named."""

AS_OFTEN = 0.25
"""Share of the resamplings from which on another effect that leads in them cannot be excluded."""

_CONTENDS = 0.5
"""Share of what the best removes from which on a law is asked again in each resampling."""

_SAME = 1e-6
"""Share of an error by which gains may differ by rounding alone: some laws move nothing, or as much as others."""

_SHORTLIST = 6
_MOST = 4
_SPOILS = 0.05
_CHANNELS = ("phase", "envelope")
_WORDS = {"phase": "frequency", "envelope": "loss"}

Settled = dict[int, tuple[HeldOut, tuple[Rows, ...]]]
"""Errors and corrected rows of each column, added to what was taken before."""


def search_of(
    decays: Sequence[PreparedDecay],
    model: Model,
    known: dict[str, float],
    terms: tuple[Term, ...],
    scales: Scales,
) -> tuple[CurveSearch, tuple[int, ...]] | None:
    """Return the search on those releases that have a curve, and their places; None where they are too short to tell."""
    modes = [_mode_of(decay) for decay in decays]
    places = tuple(i for i, mode in enumerate(modes) if mode is not None)
    found = [(decay, mode) for decay, mode in zip(decays, modes, strict=True) if mode is not None]
    if not found:
        return None
    search = CurveSearch(
        tuple(decay for decay, _ in found), tuple(mode for _, mode in found), model, known, terms, scales
    )
    return (search, places) if len(search.parts) > 1 else None


def confirmed(search: CurveSearch, places: tuple[int, ...] = ()) -> Confirmation:
    """Return what a search confirms; `places` are those of its releases among all that were given."""
    columns = tuple(range(len(search.base)))
    usual, rows = search.settled(columns, search.regression.measured)
    held = usual
    effects: list[ConfirmedEffect] = []
    undecided: dict[str, tuple[str, ...]] = {}
    unstable: dict[str, dict[str, int]] = {}
    if search.span >= RANGE:
        while len(effects) < _MOST:
            taken = _next(search, columns, held, rows, [e.explains for e in effects], undecided, unstable)
            if taken is None:
                break
            effect, column, held, rows = taken
            columns = (*columns, column)
            effects.append(effect)
    return Confirmation(
        search.whole,
        tuple(effects),
        usual,
        held,
        search.one_record,
        undecided,
        tuple(dict.fromkeys(law.name for law in search.regression.laws[len(search.base) :])),
        {
            str(law.term.strength): max(float(strength), law.term.effect.strength.low)
            for law, strength in zip(search.base, held.strengths.shared, strict=False)
        },
        places,
        unstable,
    )


def _mode_of(decay: PreparedDecay) -> IsolatedMode | None:
    try:
        return IsolatedMode.of(decay.window)
    except NotIdentifiable:
        return None


def _next(
    search: CurveSearch,
    columns: tuple[int, ...],
    held: HeldOut,
    rows: tuple[Rows, ...],
    explained: list[str],
    undecided: dict[str, tuple[str, ...]],
    unstable: dict[str, dict[str, int]],
) -> tuple[ConfirmedEffect, int, HeldOut, tuple[Rows, ...]] | None:
    """Return the next effect, its column, the errors with it and the corrected rows; None where none is worth it."""
    settled = {c: search.settled((*columns, c), rows) for c in _screened(search, columns, held, rows)}
    laws = search.regression.laws
    for channel in sorted(_CHANNELS, key=lambda c: -held.mean(c)):
        what = _WORDS[channel]
        if what in undecided or (search.one_record and what in explained):
            continue  # the one curve of one record is not divided between two laws
        good = [
            column
            for column, (after, _) in settled.items()
            if _worth(held, after, channel, what in explained)
            and search.plausible(column, after)
            and both_faces(laws[column].term, held, after, channel)
        ]
        if not good:
            continue
        left = {c: settled[c][0].mean(channel) for c in settled}
        chosen = choose(
            laws, good, _central(settled, held), left, held.mean(channel), one_record=search.one_record
        )
        if chosen.drifts or len(chosen.rivals) > MOST_RIVALS:
            undecided[what] = chosen.names
            continue
        if chosen.lead is None:
            continue
        lead = chosen.lead
        often = _often(search, (columns, rows), settled, good, held, channel)
        alike = (laws[lead].name, *chosen.rivals)
        alike = (*alike, *_as_often(often, alike))
        if sum(often[name] for name in alike) < STABLE * often.total() or len(alike) - 1 > MOST_RIVALS:
            unstable[what] = dict(often.most_common())
            undecided[what] = tuple(name for name in unstable[what] if name) or chosen.names
            continue
        after, own = settled[lead]
        effect = ConfirmedEffect(
            term=laws[lead].term,
            strength=float(after.strengths.shared[-1]),
            inner=laws[lead].inner,
            explains=what,
            before=held.typical(channel),
            after=after.typical(channel),
            better=after.better(held, channel),
            parts=len(after.foretold),
            rivals=alike[1:],
            leads=sum(often[name] for name in alike),
            resamplings=often.total(),
        )
        return effect, lead, after, own
    return None


def _as_often(often: Counter[str], alike: tuple[str, ...]) -> tuple[str, ...]:
    """Return the other effects that lead in so many resamplings that they cannot be excluded."""
    return tuple(n for n, k in often.most_common() if n and n not in alike and k >= AS_OFTEN * often.total())


def _often(
    search: CurveSearch,
    so_far: tuple[tuple[int, ...], tuple[Rows, ...]],
    settled: Settled,
    good: Sequence[int],
    held: HeldOut,
    channel: str,
) -> Counter[str]:
    """Return in how many resamplings of the cycles each effect leads, by name; "" where none does."""
    best = max(held.mean(channel) - settled[c][0].mean(channel) for c in good)
    drifts = [c for c in settled if search.regression.laws[c].term.effect.of_time]
    close = [
        c
        for c in dict.fromkeys((*good, *drifts))
        if held.mean(channel) - settled[c][0].mean(channel) >= _CONTENDS * best
    ]
    columns, rows = so_far
    contenders = [Contender(c, (*columns, c), settled[c][1]) for c in close]

    def lead(left: Mapping[int, float], before: float) -> int | None:
        still = [c for c in good if c in left and before - left[c] >= SHARE * before]
        if not still:
            return None
        keep = _central(settled, held)
        laws = search.regression.laws
        return choose(laws, still, keep, left, before, one_record=search.one_record).lead

    places = leaders(search, contenders, Contender(-1, columns, rows), channel, lead)
    return Counter("" if place is None else search.regression.laws[place].name for place in places)


def _central(settled: Settled, before: HeldOut) -> Callable[[list[int]], list[int]]:
    """Return what keeps columns that leave of the centre's error hardly more than the best: one side moves it."""

    def keep(near: list[int]) -> list[int]:
        left = {c: settled[c][0].mean("centre") for c in near}
        most = min(left.values(), default=0.0) + max(WORTH, SHARE * before.mean("centre"))
        return [c for c in near if left[c] <= most]

    return keep


def _worth(before: HeldOut, after: HeldOut, channel: str, again: bool) -> bool:
    """Whether an effect removes enough of one kind of error, on most parts, and spoils nothing else."""
    share, worth = SHARE, SECOND_WORTH if again else WORTH
    if before.typical(channel) - after.typical(channel) < max(share * before.typical(channel), worth):
        return False
    for fitted in (False, True):
        old, new = before.mean(channel, fitted=fitted), after.mean(channel, fitted=fitted)
        if old - new < max(share * old, worth):
            return False
    if after.better(before, channel) < MOST_PARTS * len(after.foretold):
        return False
    other = "phase" if channel == "envelope" else "envelope"
    gained = before.mean(channel) - after.mean(channel)
    spoils = max(WORTH, _SPOILS * gained)
    return (
        after.mean(other) < before.mean(other) + spoils
        and after.mean("centre") < before.mean("centre") + spoils
    )


def both_faces(term: Term, before: HeldOut, after: HeldOut, channel: str) -> bool:
    """Whether what an effect with memory says of the other kind of error is borne out too.

    What follows the motion late is part spring and part damper, by one strength.
    """
    other = "phase" if channel == "envelope" else "envelope"
    return not term.force.states or after.mean(other) <= max(SHARE * before.mean(other), WORTH)


def _screened(
    search: CurveSearch, columns: tuple[int, ...], held: HeldOut, rows: tuple[Rows, ...]
) -> tuple[int, ...]:
    """Return the columns that look best for each kind of error, one an effect, with the corrections of the model so far.

    Laws of time are always among them, so that none of the amplitude is named in their place.
    """
    laws = search.regression.laws
    taken = {laws[c].name for c in columns}
    kinds = (*_CHANNELS, "centre")
    best: dict[str, dict[str, tuple[float, int]]] = {kind: {} for kind in kinds}
    for column in range(len(search.base), len(laws)):
        name = laws[column].name
        if name in taken:
            continue
        trial = search.hold_out((*columns, column), rows)
        for kind in kinds:
            gain = held.mean(kind) - trial.mean(kind)
            # what moves the centre moves the frequency too, but in second order
            least = WORTH if kind == "centre" else 0.0
            if gain > max(least, best[kind].get(name, (0.0, 0))[0] + _SAME * held.mean(kind)):
                best[kind][name] = (gain, column)
    chosen: list[int] = []
    for kind in kinds:
        order = [column for _, column in sorted(best[kind].values(), key=lambda found: -found[0])]
        chosen += order[:_SHORTLIST] + [column for column in order if laws[column].term.effect.of_time]
    return tuple(dict.fromkeys(chosen))
