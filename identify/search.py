"""The search for what is missing: one effect, or two together."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array
from identify.chance import Chance, chance_of
from identify.dropouts import stale
from identify.effects.effect import Effect
from identify.effects.library import LIBRARY
from identify.faults import FEWEST_LOST, allowance
from identify.fit import Fit, fit
from identify.floor import Floor, refine_floor
from identify.model import Model, Term
from identify.screening import promising_pairs
from identify.setting import Setting
from identify.starting import regress_model, scales_of, starting_values
from identify.suspects import Candidate, candidate_terms, residual_lines, try_terms

ADEQUATE = 3.0
"""Standard errors by which a reduced chi-square may exceed 1 and still count as at the floor."""

DOUBT = 0.5
"""Excess of the reduced chi-square that is left to the noise where its floor could only be guessed."""

_STALE_OFF = 3.5
"""Noise standard deviations off the fit at which a stale reading counts as lost."""

_BEAM = 3
_LOOKED_AT = 6
_POLISHED_SECONDS = 3
_POLISHED_BESIDE_BEST = 10
_SCREENED = 6


@dataclass(frozen=True, eq=False)
class Start:
    """A model fitted to releases, and the floor it is measured against."""

    settings: tuple[Setting, ...]
    fit: Fit
    floors: tuple[Floor, ...]

    @property
    def spread(self) -> float:
        """Standard error of the reduced chi-square of an adequate model."""
        return float(np.sqrt(np.mean([floor.chi_square_std**2 for floor in self.floors])))

    @property
    def floor_is_sure(self) -> bool:
        """Whether a misfit above the floor cannot be noise: it was seen at rest, and two channels bear each other out."""
        return all(
            setting.span.paired and all("rest" in noise.source for noise in setting.noise.values())
            for setting in self.settings
        )

    def reduced(self, found: Fit) -> float:
        """Reduced chi-square with the faults that are corrected but not named in the model counted in."""
        extra, readings = allowance(self.settings, found, found.model)
        return (found.chi_square + extra) / max(found.degrees + readings, 1)

    def adequate(self, found: Fit) -> bool:
        """Whether a fit reaches the floor, corrected faults left out; one that is not sure gets the benefit of doubt."""
        doubt = 0.0 if self.floor_is_sure else DOUBT
        return found.reduced <= 1.0 + max(ADEQUATE * self.spread, doubt)


def begin(settings: tuple[Setting, ...], model: Model, known: dict[str, float] | None = None) -> Start:
    """Fit a model and settle the floor with its residual; `known` are values to begin from, by unknown's name."""
    spans = tuple(setting.span for setting in settings)
    frequency = settings[0].frequency
    start = known if known is not None else starting_values(settings, model, {})
    found = fit(model, spans, start, frequency)
    mended = tuple(_without_stale(setting, found, i) for i, setting in enumerate(settings))
    if any(new is not old for new, old in zip(mended, settings, strict=True)):
        values = dict(zip(found.names, found.theta.tolist(), strict=True))
        found = fit(model, tuple(setting.span for setting in mended), values, frequency)
    return settle(mended, found)


def _without_stale(setting: Setting, found: Fit, i: int) -> Setting:
    """Leave out the stale readings that only a fit can tell, in channels that are known to lose readings."""
    lost, used = dict(setting.lost), dict(setting.span.used)
    for channel, mask in setting.lost.items():
        if int(mask.sum()) < FEWEST_LOST:
            continue
        off = np.abs(found.residual(channel, i)) > _STALE_OFF * setting.span.sigma[channel]
        further = stale(setting.span.readings[channel]) & off & used[channel]
        if further.any():
            lost[channel] = mask | further
            used[channel] = used[channel] & ~further
    if all(lost[channel] is setting.lost[channel] for channel in lost):
        return setting
    return replace(setting, lost=lost, span=setting.span.with_(used=used))


def settle(settings: tuple[Setting, ...], found: Fit) -> Start:
    """Return a fit measured against the floor that its own residual shows."""
    floors = refine_floor(found, tuple(setting.noise for setting in settings))
    spans = tuple(floor.on(span) for floor, span in zip(floors, found.spans, strict=True))
    values = dict(zip(found.names, found.theta.tolist(), strict=True))
    return Start(settings, fit(found.model, spans, values, found.frequency), floors)


def singles(start: Start, library: tuple[Effect, ...] = LIBRARY) -> tuple[Candidate, ...]:
    """Return the model refitted with each effect it lacks, best first."""
    terms = candidate_terms(start.fit.model, library, start.fit.spans[0])
    return try_terms(start.settings, start.fit, terms)


def chances(start: Start, library: tuple[Effect, ...] = LIBRARY) -> Chance:
    """Return what each effect would gain by chance if nothing were missing."""
    terms = candidate_terms(start.fit.model, library, start.fit.spans[0])
    return chance_of(start.settings, start.fit, terms)


@dataclass(frozen=True, eq=False)
class Pair:
    """Two effects together: the second was refitted with the first in the model."""

    first: Candidate
    second: Candidate

    @property
    def plausible(self) -> bool:
        """Whether both are the best names for what they explain."""
        return self.first.plausible and self.second.plausible


def pairs(
    start: Start, tried: tuple[Candidate, ...], library: tuple[Effect, ...] = LIBRARY
) -> tuple[Pair, ...]:
    """Return the most promising pairs of effects, best first.

    Forces that explain most together, by equation error, are fitted first; unless one of these pairs reaches the floor,
    what goes best with the best single candidates follows, faults of sensors among them. Where the floor is sure, the
    first plausible pair that reaches it ends the search.
    """
    found: list[Pair] = []
    best = _distinct(tried)[0] if tried else None
    for stage in (_screened, _greedy):
        for first, terms in stage(start, tried, library):
            polished = _POLISHED_BESIDE_BEST if first is best else _POLISHED_SECONDS
            seconds = try_terms(start.settings, first.fit, terms, polished=polished)
            if seconds:
                found.append(Pair(first, seconds[0]))
            if start.floor_is_sure and _reached(start, found):
                break
        if _reached(start, found):
            break
    return tuple(sorted(found, key=lambda pair: (not pair.plausible, pair.second.score)))


def _reached(start: Start, found: list[Pair]) -> bool:
    return any(pair.plausible and start.adequate(pair.second.fit) for pair in found)


def _screened(
    start: Start, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[tuple[Candidate, tuple[Term, ...]]]:
    """Yield the first of each screened pair with the terms of its second, which is begun from several starts.

    So the one with more inner parameters is the second; of two alike the one that is worse alone.
    """
    ranks = {candidate.name: rank for rank, candidate in enumerate(tried)}
    largest = max(start.settings, key=lambda setting: setting.amplitude)
    terms = candidate_terms(start.fit.model, library, start.fit.spans[0])
    scales = scales_of(largest, residual_lines(start.fit))
    for pair in promising_pairs(largest, start.fit.model, terms, scales)[:_SCREENED]:
        if all(name in ranks for name in pair):
            first, second = sorted(
                pair, key=lambda name: (len(tried[ranks[name]].term.effect.inner), ranks[name])
            )
            yield tried[ranks[first]], tuple(term for term in terms if term.effect.name == second)


def _greedy(
    start: Start, tried: tuple[Candidate, ...], library: tuple[Effect, ...]
) -> Iterator[tuple[Candidate, tuple[Term, ...]]]:
    """Yield the best single candidates with what may go with them; two forces are left to the screening but once."""
    for rank, first in enumerate(_distinct(tried)):
        terms = candidate_terms(first.fit.model, library, first.fit.spans[0])
        whole = rank == 0 or first.term.effect.kind == "sensor"
        yield first, terms if whole else tuple(term for term in terms if term.effect.kind == "sensor")


def _distinct(tried: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Return the first few candidates, plausible ones first: lines can follow anything for a while."""
    return tuple(sorted(tried[:_LOOKED_AT], key=lambda c: (not c.plausible, c.score))[:_BEAM])


def force_along_motion(setting: Setting, found: Fit) -> Array:
    """Return the force per unit mass of a fitted model along the measured motion, strengths by equation error, (n,)."""
    inner = {
        n: float(t) for n, t in zip(found.names, found.theta, strict=True) if "." in n and ".state" not in n
    }
    return setting.restoring - regress_model(setting, found.model, inner).residual
