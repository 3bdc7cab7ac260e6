"""The evidence for one more effect where noise is known: how much more probable the readings are with it than without.

The marginal likelihood of the model with the effect over that of the model without, by Laplace's approximation at the fit
(MacKay, *Information Theory, Inference, and Learning Algorithms*, 2003, ch. 28): half of the gain in chi-square, less what
it costs to have found the effect's own numbers anywhere in the ranges where they may lie. What both models have in common
counts in neither.
"""

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Scales
from identify.fitting.fit import Fit
from identify.fitting.initial_values import reachable_starts
from identify.fitting.parameter_layout import Unknown
from identify.model.model import Term
from identify.priors import STRENGTHS

_ROUNDING = 1e-12
"""Least eigenvalue of a matrix of correlations: what is below it is rounding."""


def evidence(base: Fit, found: Fit, scales: Scales, dispersion: float = 1.0) -> float:
    """Return the evidence (nats) for all that a fit has in its model beyond the `base`, against the base alone.

    `dispersion` is by how much a misfit that nothing explains widens the noise: 1 where the floor is sure.
    """
    return 0.5 * (base.chi_square - found.chi_square) / dispersion - price(base, found, scales, dispersion)


def price(base: Fit, found: Fit, scales: Scales, dispersion: float = 1.0) -> float:
    """Return what it costs to have found all that a fit has beyond the `base` in the ranges where it may lie, in nats."""
    terms = {term.effect.name: term for term in found.model.terms if term.effect.name not in base.model}
    own = [j for j, unknown in enumerate(found.unknowns) if unknown.name not in base.names]
    widths = np.array([_width(found.unknowns[j], float(found.theta[j]), terms, scales) for j in own])
    counts = widths > 0.0  # a strength of none has gained nothing and costs nothing
    places = np.array(own, dtype=int)[counts]
    cost = _cost(dispersion * found.covariance[np.ix_(places, places)], widths[counts])
    return cost + float(sum(np.log(len(term.effect.variants)) for term in terms.values()))


def _cost(covariance: Array, widths: Array) -> float:
    """Return the logarithm of the ranges over the volume in them that the readings leave, in nats.

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
    """Return the width of the range in which an unknown may lie, in its unit: the inverse of its prior density at a value.

    Uniform for states, phases and the frequencies of lines, else in the logarithm, over what a fit may reach.
    """
    if unknown.id.role != "parameter":
        between = unknown.high - unknown.low
        return between if np.isfinite(between) else 2.0 * unknown.size
    term = terms[unknown.id.effect]
    if term.effect.line and unknown.unit == "rad":
        return 2.0 * np.pi
    if term.effect.line and unknown.unit == "Hz":
        return 0.5 * scales.rate
    starts = (start.get(unknown.id.parameter, 0.0) for start in reachable_starts(term, scales))
    sizes = sorted(abs(size) for size in starts if size)
    if len(sizes) > 1 and sizes[0] < sizes[-1]:
        return float(np.log(sizes[-1] / sizes[0])) * abs(value)
    sides = 1.0 if np.isfinite(unknown.low) else 2.0
    return sides * float(np.log(STRENGTHS[-1] / STRENGTHS[0])) * abs(value)
