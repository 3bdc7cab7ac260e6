"""The evidence for several effects, and the one table that turns it into a verdict.

The evidence for one more effect where noise is known: how much more probable the readings are with it than without.

The marginal likelihood of the model with the effect over that of the model without, by Laplace's approximation at the fit
(MacKay, *Information Theory, Inference, and Learning Algorithms*, 2003, ch. 28): half of the gain in chi-square, less what
it costs to have found the effect's own numbers anywhere in the ranges where they may lie. What both models have in common
counts in neither.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Effect, Scales
from identify.effects.force_effect import ForceEffect
from identify.fitting.fit import Fit
from identify.fitting.initial_values import close_starts, term_starts
from identify.fitting.parameter_layout import Unknown
from identify.model.model import Term
from identify.priors import DOUBT, MOST_ALIKE, STRENGTHS

Decided = Literal["nothing", "named", "no name", "may drift", "too many", "leaves drift"]
"""What the table decides; "leaves drift" is what it names where that leaves a random walk above the noise."""


@dataclass(frozen=True)
class Evidence:
    """The evidence for one more law: `nats` of each against the model without it, by name, and the verdict.

    `names` are those that are not distinguishable, the one that leads first; `explains` is "frequency" or "loss".
    `unnamed` is the evidence for a law outside the library in their place, and `beside` that for one beside the leader.
    """

    nats: dict[str, float]
    verdict: Decided
    names: tuple[str, ...] = ()
    explains: str = ""
    unnamed: float = -np.inf
    beside: float = -np.inf


def nothing(nats: Sequence[float]) -> float:
    """Return the probability that none of several effects is there, from the evidence for each (nats).

    Before the data, none is as probable as all together, and all of these are equally probable.
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
    drift_weighed: bool = False,
    alpha: float = DOUBT,
) -> Evidence:
    """Decide what the evidence for several laws names: the one table of verdicts.

    Before the data, none is as probable as all laws together, and all of these are equally probable. The indistinguishable
    laws are the likeliest ones that leave out DOUBT of the probability at most. `unnamed` is the evidence for a law outside
    the library in their place, at first as probable as each. Laws of time represent any drift unless a drift is part of
    every hypothesis (`drift_weighed`).

    | probability | verdict |
    |---|---|
    | of none above `alpha` | nothing |
    | of a law outside the library in their place above DOUBT | no name |
    | of the laws of time above DOUBT, if it is a law | may drift |
    | of any MOST_ALIKE laws below 1 - DOUBT | too many |
    | else | named: those that are not distinguishable, the likeliest first |
    """
    places = list(effects)
    order = sorted(
        nats, key=lambda name: (-round(nats[name], 1), places.index(name))
    )  # of equal ones the library's first

    def decided(verdict: Decided, names: tuple[str, ...] = ()) -> Evidence:
        return Evidence(dict(nats), verdict, names, unnamed=unnamed)

    if nothing(tuple(nats.values())) > alpha:
        return decided("nothing")
    most = max(*nats.values(), unnamed)
    weight = {name: float(np.exp(nats[name] - most)) for name in order}
    total = sum(weight.values())
    above = np.cumsum([weight[name] for name in order])
    near = tuple(order[: 1 + int(np.searchsorted(above, (1.0 - DOUBT) * total))])
    if np.exp(unnamed - most) > DOUBT * (total + np.exp(unnamed - most)):
        return decided("no name", near)
    if not drift_weighed and sum(weight[name] for name in order if effects[name].of_time) > DOUBT * total:
        return decided("may drift", near)
    return decided("named" if len(near) <= MOST_ALIKE else "too many", near)


def complexity(effect: Effect) -> int:
    """Count an effect's own constants and add its rarity: of indistinguishable effects the least complex leads.

    One that may be the whole of a linear law, as gravity of an angle's spring, has no strength of its own.
    """
    own_strength = not (isinstance(effect, ForceEffect) and effect.may_be_all_of is not None)
    return own_strength + len(effect.inner) + effect.rarity


_ROUNDING = 1e-12
"""Least eigenvalue of a matrix of correlations: what is below it is rounding."""


def evidence(base: Fit, found: Fit, scales: Scales, unit: float = 1.0) -> float:
    """Return the evidence (nats) for the effects of a fit beyond the `base`, against the base alone.

    `unit` is the factor by which what no effect explains widens the noise, the unit in which chi-square counts.
    """
    return 0.5 * (base.chi_square - found.chi_square) / unit - price(base, found, scales, unit)


def price(base: Fit, found: Fit, scales: Scales, unit: float = 1.0) -> float:
    """Return the price (nats) of the parameters of a fit beyond the `base`, found anywhere in their ranges."""
    terms = {term.effect.name: term for term in found.model.terms if term.effect.name not in base.model}
    own = [j for j, unknown in enumerate(found.unknowns) if unknown.name not in base.names]
    widths = np.array([_width(found.unknowns[j], float(found.theta[j]), terms, scales) for j in own])
    counts = widths > 0.0  # a strength of none has gained nothing and costs nothing
    places = np.array(own, dtype=int)[counts]
    cost = _cost(unit * found.covariance[np.ix_(places, places)], widths[counts])
    return cost + float(sum(np.log(len(term.effect.variants)) for term in terms.values()))


def _cost(covariance: Array, widths: Array) -> float:
    """Return the logarithm of the volume of the ranges over the volume that the readings leave, in nats.

    ln det(1 + (2 pi C)^-1) / 2 of the covariance C in squares of the ranges, by correlations: what the readings do not
    determine costs nothing, however large its variance.
    """
    variance = np.diag(covariance) / widths**2
    known = np.isfinite(variance) & (variance > 0.0)
    size, variance = np.sqrt(np.diag(covariance)[known]), variance[known]
    alone = covariance[np.ix_(known, known)] / np.outer(size, size)
    share = np.sqrt(variance / (variance + 0.5 / np.pi))
    within = alone * np.outer(share, share)
    np.fill_diagonal(within, 1.0)
    return 0.5 * float(np.sum(np.log1p(0.5 / np.pi / variance))) + 0.5 * (_log_det(within) - _log_det(alone))


def _log_det(correlations: Array) -> float:
    return float(np.sum(np.log(np.maximum(np.linalg.eigvalsh(correlations), _ROUNDING))))


def _width(unknown: Unknown, value: float, terms: dict[str, Term], scales: Scales) -> float:
    """Return the width of an unknown's range, in its unit: the inverse of its prior density at a value.

    Uniform for bounded states, phases and the frequencies of lines, Cauchy's for other states: a light oscillator may
    swing by many times the motion. Else uniform in the logarithm, over what a fit may reach.
    """
    if unknown.id.role != "parameter":
        between, size = unknown.high - unknown.low, unknown.size
        return between if np.isfinite(between) else np.pi * size * (1.0 + (value / size) ** 2)
    term = terms[unknown.id.effect]
    if term.effect.line and unknown.unit == "rad":
        return 2.0 * np.pi
    if term.effect.line and unknown.unit == "Hz":
        return 0.5 * scales.rate
    reach = close_starts(term, scales) if term.is_force else term_starts(term, scales)
    sizes = sorted(abs(start[unknown.id.parameter]) for start in reach if start.get(unknown.id.parameter))
    if len(sizes) > 1 and sizes[0] < sizes[-1]:
        return float(np.log(sizes[-1] / sizes[0])) * abs(value)
    sides = 1.0 if np.isfinite(unknown.low) else 2.0
    return sides * float(np.log(STRENGTHS[-1] / STRENGTHS[0])) * abs(value)
