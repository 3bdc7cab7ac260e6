"""The null distribution: how much each suspect would lower chi-square if nothing were missing.

Under the present model the readings differ from the prediction by noise alone. A suspect of small strength changes the
prediction along one direction (its column) for each value of its inner parameters; what the fit's own parameters can
follow is projected out. For drawn noise, the best drop of chi-square over the suspect's columns is a draw from its null
distribution, and the smallest tail probability over the whole library one from that of the search. A force is one for
all releases; a sensor's fault has parameters in each, whose drops add up.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from identify.arrays import Array
from identify.diagnosis.null_faults import fault_drops
from identify.diagnosis.null_forces import force_places
from identify.diagnosis.null_lines import likeliest_line, line_drops
from identify.diagnosis.places import Starts
from identify.fitting.fit import Fit
from identify.fitting.initial_values import reachable_starts, scales_of, term_starts
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.fitting.tangent import Tangent
from identify.model.model import Term
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay

_DRAWS = 400
_FEWEST_DRAWS = 100
_MOST_NUMBERS = 4_000_000
"""Random numbers that are drawn: of records of more than 10,000 readings there are fewer draws, 100 at least."""

_TAIL = 0.1

_CLEARLY = 0.16
"""Standard error of the slope of the last tenth of 400 draws, relative."""

_WEAKEST = 0.1
"""Least strength of drawn noise, in units of the floor, however unsure that is."""


@dataclass(frozen=True, eq=False)
class NullDistribution:
    """Null distributions of the drop of chi-square, by effect name, and of the search over all of them.

    `drops` maps an effect to its draws, sorted; `search` holds the largest surprise (-ln p) of each draw over
    the library, sorted. `likeliest` are the places at which each variant lowers the fit's own misfit most, which goes with
    the draws as one more: where fits begin, so that the search finds what it is compared with.
    """

    drops: dict[str, Array]
    search: Array
    likeliest: Mapping[tuple[str, ...], Starts] = field(default_factory=dict)

    def surprise(self, effect: str, drop: float) -> float:
        """Return -ln of the probability that chance lowers chi-square this much by this effect alone."""
        return float(_surprise(self.drops[effect], np.array([drop]))[0]) if effect in self.drops else 0.0

    def p_value(self, effect: str, drop: float, *, against: float = 0.0) -> float:
        """Return the probability that chance gives any suspect in the library as good a reason.

        `against` are nats that speak against this one beside chi-square.
        """
        surprise = self.surprise(effect, drop) - against
        return float(np.exp(-_surprise_of_search(self.search, np.array([surprise]))[0]))


def null_distribution(
    decays: tuple[PreparedDecay, ...],
    base: Fit,
    terms: tuple[Term, ...],
    *,
    unsure: tuple[dict[str, float], ...] = (),
    seed: int = 0,
    draws: int = _DRAWS,
) -> NullDistribution:
    """Draw what each suspect would gain by chance; the same seed and the same releases give the same draws.

    The draws are the same in whatever order the releases come, mirrored where a release is mirrored, and the same where
    readings differ by rounding alone. Other releases get other draws: what 400 draws happen to be off would otherwise
    be off alike on all records.

    `unsure` is the relative standard error of each channel's noise in each window: it may be so much stronger or weaker
    than the floor that gains are measured in. None where the noise is known.
    """
    readings = sum(int(mask.sum()) for window in base.windows for mask in window.used.values())
    draws = min(draws, max(_FEWEST_DRAWS, _MOST_NUMBERS // max(readings, 1)))
    theta = base.theta
    problem = Problem(base.model, base.windows, base.frequency)
    residual, jacobian = linearise(problem, theta)
    seeds = [seed_of(window, seed) for window in base.windows]
    noise = np.concatenate(
        [drawn_noise(window, own, draws) for window, own in zip(base.windows, seeds, strict=True)]
    )
    if unsure:
        noise *= _strengths(base, unsure, np.random.default_rng(sorted(seeds)), draws)
    for one in problem.expected:  # what each release has of its own, where it is expected
        random = np.random.default_rng((*seeds[one.windows[0]], one.shared))
        noise = np.concatenate([noise, random.standard_normal((1, draws))])
    low, high = theta <= problem.low, theta >= problem.high
    tangent = jacobian.tangent(~(low | high))
    for at, side in [
        *((j, 1.0) for j in np.flatnonzero(low).tolist()),
        *((j, -1.0) for j in np.flatnonzero(high).tolist()),
    ]:
        noise = _pressed(noise, side * jacobian.column(at), tangent)
    # The fit's own misfit goes last. What it and a presence have in common lowers chi-square where they differ in sign.
    noise = np.column_stack([-noise, -residual])
    free = tangent.free(noise)
    scales = scales_of(decays[0], dict.fromkeys(base.windows[0].channels, ()))
    drops: dict[str, Array] = {}
    likeliest: dict[tuple[str, ...], Starts] = {}
    for term in terms:
        name = term.effect.name
        if term.effect.line:
            best = line_drops(base, term, noise[:, :-1])
            line = likeliest_line(base, term, noise[:, -1:])
            starts = term_starts(term, scales_of(decays[0], {line.channel: (line.values,)}))
            if term.is_force:
                starts = force_places(decays, base, term, starts, tangent, free[:, -1:]).likeliest(0)
            likeliest[term.variant] = starts
        elif term.is_force:
            places = force_places(decays, base, term, reachable_starts(term, scales), tangent, free)
            best = places.best[:-1]
            if len(places.starts) > 1:
                likeliest[term.variant] = places.likeliest(-1)
        else:
            best = fault_drops(base, term, scales, tangent, free[:, :-1])
        drops[name] = np.maximum(drops[name], best) if name in drops else best
    drawn = {name: np.sort(found) for name, found in drops.items()}
    surprises = [_surprise(drawn[name], found) for name, found in drops.items()]
    search = np.max(surprises, axis=0) if surprises else np.zeros(draws)  # of no effect nothing is expected
    return NullDistribution(drawn, np.sort(search), likeliest)


def drawn_noise(window: FitWindow, seed: tuple[int, ...], draws: int) -> Array:
    """Draw the noise of one release, (readings, draws), on the side to which it was released."""
    random = np.random.default_rng(seed)
    first = window.readings[window.channels[0]]
    side = float(np.sign(first[np.argmax(np.abs(first))])) or 1.0
    return side * np.concatenate([window.draw_noise(channel, random, draws) for channel in window.channels])


def seed_of(window: FitWindow, seed: int = 0) -> tuple[int, ...]:
    """Return numbers that tell one release from another: a seed, and the rms of its readings to four figures."""
    rms = (float(np.sqrt(np.mean(window.readings[channel] ** 2))) for channel in window.channels)
    return seed, *(round(1e4 * np.log(max(size, 1e-300))) & 0xFFFFFFFF for size in rms)


def _strengths(
    base: Fit, unsure: tuple[dict[str, float], ...], random: np.random.Generator, draws: int
) -> Array:
    """Return how strong the noise of each reading may be in units of the floor, (readings, draws).

    A channel's error is one in all windows: they share their sensor, and most of them their rest.
    """
    drawn: dict[str, Array] = {}
    rows = []
    for window, relative in zip(base.windows, unsure, strict=True):
        for channel in window.channels:
            if channel not in drawn:
                drawn[channel] = random.standard_normal(draws)
            strength = np.maximum(1.0 + relative.get(channel, 0.0) * drawn[channel], _WEAKEST)
            rows.append(np.broadcast_to(strength, (int(window.used[channel].sum()), draws)))
    return np.concatenate(rows)


def _pressed(noise: Array, column: Array, tangent: Tangent) -> Array:
    """Return the draws under which a parameter at its bound would stay there: those that lift it are mirrored.

    `column` is how the misfit changes as the parameter moves into its range.
    """
    free = tangent.free(column)
    size = float(np.linalg.norm(free))
    if not size > 1e-9 * float(np.linalg.norm(column)):
        return noise
    direction = free / size
    lifted = np.minimum(direction @ noise, 0.0)
    return noise - 2.0 * np.outer(direction, lifted)


def _surprise(draws: Array, values: Array) -> Array:
    """Return -ln of the tail probability of drops of chi-square, from their draws, sorted.

    Beyond the last tenth of the draws the hazard is that of a chi-square, (1 - c / x) / 2 at x, where c is two less than the
    degrees of freedom: of one effect's it is nearly 0, of what many releases have each for itself it is large. The
    mean of the last tenth tells c, where it differs clearly from 0: two laws of one strength have one tail.
    """
    knee = draws[int((1.0 - _TAIL) * len(draws))]
    mean = float(np.mean(draws[draws >= knee]))
    share = 1.0 - 2.0 / max(mean - knee, 1e-12)
    # No more than the knee: a hazard below 0 would make the larger gain the commoner.
    crowded = min(mean * share, knee) if knee > 0.0 and share > _CLEARLY else 0.0
    beyond = np.maximum(values, knee)
    rise = 0.5 * (beyond - knee - crowded * np.log(beyond / knee)) if crowded > 0.0 else 0.5 * (beyond - knee)
    return _with_tail(draws, values, knee, rise)


def _surprise_of_search(draws: Array, values: Array) -> Array:
    """Return -ln of the tail probability of the largest surprise over the library; a surprise has slope 1 itself."""
    knee = draws[int((1.0 - _TAIL) * len(draws))]
    return _with_tail(draws, values, knee, values - knee)


def _with_tail(draws: Array, values: Array, knee: float, rise: Array) -> Array:
    """Return -ln of the tail probability: by rank up to the knee, and beyond it what it is there plus a rise."""
    n = len(draws)
    rank = np.searchsorted(draws, values, side="left")
    inside = np.minimum(-np.log((n - rank + 0.5) / (n + 0.5)), -np.log(_TAIL))
    return np.asarray(np.where(values > knee, -np.log(_TAIL) + rise, inside))
