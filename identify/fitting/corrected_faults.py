"""Faults that every fit corrects and that are judged afterwards: the gain between the channels, lost readings."""

from dataclasses import dataclass

import numpy as np

from identify.effects.library import CORRECTED
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay

UNSTATED_GAIN_UNCERTAINTY = 0.03
"""Relative uncertainty allowed to a pair of channels whose calibration says nothing: ordinary sensors are 1 to 5 % off."""

FEWEST_LOST = 3
_BY_CHANCE = 4.0
"""Drop of chi-square that is no surprise."""

_CLEAR_DROP = 12.0
_WORTH_A_REMARK = 0.002
"""Relative error of the gain from which on it is remarked on where the calibration would allow it."""


@dataclass(frozen=True, eq=False)
class CorrectedFault:
    """A sensor's fault that every fit corrects, with the chi-square that it would add if it were not corrected.

    `drop` is that chi-square, in units of the noise, of so many `readings` (0 where it is one number's); `parameters`
    what was found; `term` names it in a model. `remarked` tells that the fault is there, though no more than its
    calibration leaves open: worth a remark, and no verdict. `words` say what was found and what is left open, in a clause;
    "" where the parameters say it. `misfit` is the reduced chi-square of all other readings, 1 at least: where all err by
    more than the noise, it is no surprise here.
    """

    term: Term
    drop: float
    readings: int
    parameters: dict[str, Estimate]
    remarked: bool = False
    words: str = ""
    misfit: float = 1.0

    @property
    def surplus(self) -> float:
        """The drop that would be as improbable by chance, had it one degree of freedom (Chernoff's bound for more)."""
        degrees, drop = max(self.readings, 1), self.drop / self.misfit
        if degrees == 1:
            return drop
        return max(drop - degrees - degrees * float(np.log(max(drop / degrees, 1.0))), 0.0)

    @property
    def p_value(self) -> float:
        """The probability of such a drop by chance and within the calibration's uncertainty."""
        return float(np.exp(-0.5 * max(self.surplus - _BY_CHANCE, 0.0)))


def corrected_faults(decays: tuple[PreparedDecay, ...], fit: Fit) -> tuple[CorrectedFault, ...]:
    """List the faults that a fit has corrected, each with the chi-square without the correction; largest first."""
    faults = [f for f in (_gain(decays, fit), *_lost(decays, fit)) if f is not None]
    return tuple(sorted(faults, key=lambda fault: -fault.drop))


def unnamed_faults(decays: tuple[PreparedDecay, ...], fit: Fit) -> tuple[CorrectedFault, ...]:
    """List the faults that a fit has corrected and that its model does not name; largest first."""
    return tuple(f for f in corrected_faults(decays, fit) if f.term.effect.name not in fit.model)


def _gain(decays: tuple[PreparedDecay, ...], fit: Fit) -> CorrectedFault | None:
    """Judge the mean gain of all releases: one pair of sensors has one calibration, whose error all releases share."""
    errors, variances, allowed = [], [], []
    for i, prepared in enumerate(decays):
        gain = fit.nuisance("gain", i)
        if gain is None:
            continue
        variance = gain.std**2 * max(fit.reduced, 1.0)
        if not 0.0 < variance < np.inf:  # the gain is held, or the motion diverged
            continue
        errors.append(gain.value - 1.0)
        variances.append(variance)
        allowed.append(prepared.window.gain_uncertainty or UNSTATED_GAIN_UNCERTAINTY)
    if not errors:
        return None
    weights = 1.0 / np.array(variances)
    mean = float(np.average(errors, weights=weights))
    own = float(weights.sum() ** -0.5)
    open_ = float(np.mean(allowed))
    variance = own**2 + open_**2
    drop = mean**2 / variance
    error = Estimate(mean, float(np.sqrt(variance)), "1")
    remarked = abs(mean) > max(_WORTH_A_REMARK, _CLEAR_DROP**0.5 * own)
    stated = all(prepared.window.gain_uncertainty for prepared in decays)
    words = _differ(mean, own, open_, stated=stated)
    fault = CORRECTED["gain"]
    return CorrectedFault(Term(fault), drop, 0, {fault.strength.name: error}, remarked, words)


def _differ(mean: float, own: float, open_: float, *, stated: bool) -> str:
    """Say by how much two sensors differ, and how sure their calibrations are: a standard uncertainty, no limit."""
    size, whose = abs(mean), "is stated" if stated else "is assumed, for none is stated"
    digits = max(0, min(4, 1 - int(np.floor(np.log10(max(100.0 * own, 1e-4))))))
    return (
        f"the two sensors differ by {100.0 * size:.{digits}f} ± {100.0 * own:.{digits}f} %; a standard uncertainty of "
        f"{100.0 * open_:.2g} % of their calibrations {whose}"
    )


def _lost(decays: tuple[PreparedDecay, ...], fit: Fit) -> list[CorrectedFault]:
    faults, fault = [], CORRECTED["lost readings"]
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
            misfit = max(fit.reduced, 1.0)
            faults.append(CorrectedFault(term, drop, count, {fault.strength.name: share}, misfit=misfit))
    return faults
