"""Faults that every fit allows for and that are judged afterwards: the gain between the channels, lost readings."""

from dataclasses import dataclass

import numpy as np

from identify.effects.library import fault_allowed_as
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.model.model import Model, Term
from identify.preprocessing.prepared_decay import PreparedDecay

UNSTATED_GAIN_UNCERTAINTY = 2e-4
"""Relative uncertainty allowed to a pair of channels whose calibration says nothing."""

FEWEST_LOST = 3
_SIGNIFICANT_DROP = 12.0


@dataclass(frozen=True, eq=False)
class CorrectedFault:
    """A sensor's fault that is corrected in every fit: what it would add to chi-square if it were not allowed for.

    `drop` is that chi-square, in units of the noise; `parameters` what was found; `term` names it in a model.
    """

    term: Term
    drop: float
    readings: int
    parameters: dict[str, Estimate]

    @property
    def significant(self) -> bool:
        """Whether it is worth a report."""
        return self.drop > _SIGNIFICANT_DROP


def corrected_faults(decays: tuple[PreparedDecay, ...], fit: Fit) -> tuple[CorrectedFault, ...]:
    """Return the faults that a fit has allowed for, each with what it would cost to do without; largest first."""
    faults = [f for f in (_gain(decays, fit), *_lost(decays, fit)) if f is not None]
    return tuple(sorted(faults, key=lambda fault: -fault.drop))


def allowance(decays: tuple[PreparedDecay, ...], fit: Fit, model: Model) -> tuple[float, int]:
    """Return the chi-square and the readings of corrected faults that a model does not name."""
    unnamed = [f for f in corrected_faults(decays, fit) if f.term.effect.name not in model]
    return sum(f.drop for f in unnamed), sum(f.readings for f in unnamed)


def _gain(decays: tuple[PreparedDecay, ...], fit: Fit) -> CorrectedFault | None:
    drop, weights, values = 0.0, [], []
    for i, prepared in enumerate(decays):
        gain = fit.nuisance("gain", i)
        if gain is None or not np.isfinite(gain.std):
            continue
        allowed = prepared.window.gain_uncertainty or UNSTATED_GAIN_UNCERTAINTY
        inflated = gain.std**2 * max(fit.reduced, 1.0) + allowed**2
        if not np.isfinite(inflated):  # the motion ran away
            continue
        drop += (gain.value - 1.0) ** 2 / inflated
        weights.append(1.0 / inflated)
        values.append(gain.value - 1.0)
    if not values or not np.isfinite(drop):
        return None
    mean = float(np.average(values, weights=weights))
    error = Estimate(mean, float(np.sum(weights) ** -0.5), "1")
    fault = fault_allowed_as("gain")
    return CorrectedFault(Term(fault), drop, 0, {fault.strength.name: error})


def _lost(decays: tuple[PreparedDecay, ...], fit: Fit) -> list[CorrectedFault]:
    faults, fault = [], fault_allowed_as("lost readings")
    for channel in fit.windows[0].channels:
        drop, count, total = 0.0, 0, 0
        for i, (prepared, window) in enumerate(zip(decays, fit.windows, strict=True)):
            lost = prepared.lost.get(channel)
            if lost is None or channel not in window.readings:
                continue
            off = fit.residual(channel, i)[lost[: len(window)]] / window.sigma[channel]
            off = off[np.isfinite(off)]
            drop += float(np.sum(off**2))
            count += len(off)
            total += len(window)
        if count >= FEWEST_LOST:
            share = Estimate(count / total, float(np.sqrt(count)) / total, "1")
            term = Term(fault, {"channel": channel})
            faults.append(CorrectedFault(term, drop, count, {fault.strength.name: share}))
    return faults
