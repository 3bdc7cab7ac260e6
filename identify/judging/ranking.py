"""The ranking: the evidence of each candidate, what may be claimed, and what is not distinguishable.

Evidence at rest: a hum is there before the release, a force that shakes the mass is not seen while it is held.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.effects.families import FAMILY_OF
from identify.effects.sensor_fault import SensorFault
from identify.evidence import evidence, nothing
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit
from identify.judging.suspects import BEHIND, Candidate, laws_of_families
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import CLEAR, RIVALS_WITHIN


def rivals_of(entry: Candidate, ranked: tuple[Candidate, ...]) -> tuple[str, ...]:
    """List the claimed candidates that explain the record as well as one of them."""
    if not entry.claimed:
        return ()
    return tuple(
        other.name
        for other in ranked
        if other is not entry and other.claimed and abs(other.evidence - entry.evidence) < RIVALS_WITHIN
    )


def rank(baseline: Baseline, tried: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Sort the candidates by their evidence: plausible claims first, then implausible ones, then the rest.

    A candidate is claimed where it is improbable that nothing is missing, if it is better than nothing by as much.
    """
    unit = chi_square_unit(baseline, [c.fit for c in tried if c.plausible])
    weighed = [weigh_candidate(baseline, baseline.fit, candidate, unit) for candidate in tried]
    sure = nothing([one.evidence for one in weighed]) < baseline.alpha
    ranked = (replace(one, claimed=sure and one.evidence > -np.log(baseline.alpha)) for one in weighed)
    return _line_of_sensor_first(tuple(sorted(ranked, key=_order)))


def with_laws_between(baseline: Baseline, ranked: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Try the laws of the families of claimed effects, and add those that are better than all of their members.

    Where an effect reaches the floor, families of those that leave much more are not tried.
    """
    claimed = [one for one in ranked if one.claimed]
    reach = [one.fit.chi_square for one in claimed if one.plausible and baseline.adequate(one.fit)]
    most = BEHIND * min(reach, default=np.inf)
    nats = {one.name: one.evidence for one in ranked}

    def is_better(law: Candidate) -> bool:
        own = weigh_candidate(baseline, baseline.fit, law, ranked[0].unit).evidence
        members = FAMILY_OF[law.term.effect].members
        return law.name not in nats and all(own > nats.get(member, -np.inf) for member in members)

    laws = laws_of_families(baseline, [one.name for one in claimed if one.fit.chi_square < most])
    better = tuple(filter(is_better, laws))
    return rank(baseline, (*ranked, *better)) if better else ranked


def weigh_candidate(baseline: Baseline, without: Fit, candidate: Candidate, unit: float) -> Candidate:
    """Weigh a candidate against the fit `without` it in a `unit` of chi-square, with what the rest says of it.

    A law of a family is less probable than an effect of the library, by the odds at which two are distinguishable.
    """
    nats = evidence(without, candidate.fit, baseline.scales, unit)
    nats += at_rest(baseline.decays, candidate.fit, candidate.term)
    if candidate.term.effect in FAMILY_OF:
        nats -= RIVALS_WITHIN
    return replace(candidate, evidence=nats, unit=unit)


def _line_of_sensor_first(ranked: tuple[Candidate, ...]) -> tuple[Candidate, ...]:
    """Put a sensor's line before a force where this record does not distinguish the two.

    A force far above the mass's own frequency moves one channel only, as hum does: the sensor's is the lesser claim.
    """
    names = rivals_of(ranked[0], ranked) if ranked and ranked[0].term.is_force else ()
    lines = (e for e in ranked if e.term.effect.line and not e.term.is_force)
    hum = next((line for line in lines if line.plausible and line.name in names), None)
    return ranked if hum is None else (hum, *(entry for entry in ranked if entry is not hum))


def _order(entry: Candidate) -> tuple[int, float]:
    tier = 2 if not entry.claimed else 0 if entry.plausible else 1
    return tier, -entry.evidence


def chi_square_unit(baseline: Baseline, tried: Sequence[Fit]) -> float:
    """Return the unit in which chi-square counts: that of the best refit, times the readings worth an independent one."""
    best = min(tried, key=lambda found: found.chi_square, default=baseline.fit)
    lengths = []
    for i, window in enumerate(best.windows):
        for channel in window.channels:
            lengths.append(_correlation_length(best.in_noise(channel, i)))
    return max(1.0, best.reduced * float(np.mean(lengths)))


def _correlation_length(values: Array) -> float:
    """Count the readings that are worth one independent reading, from the autocorrelation up to its first zero."""
    n = len(values)
    power = np.abs(np.fft.rfft(values - values.mean(), 2 * n)) ** 2
    correlation = np.fft.irfft(power)[:n]
    if correlation[0] <= 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0.0)
    return float(1.0 + 2.0 * correlation[1 : below[0] if len(below) else n].sum())


def at_rest(decays: tuple[PreparedDecay, ...], found: Fit, term: Term) -> float:
    """Return the evidence (nats) of the rest before the release for a sensor's fault, against a constant.

    Negative where the fault ought to show at rest and does not, and for a force whose line a sensor shows while the mass is
    held; 0 for everything that says nothing of the rest.
    """
    effect, channel = term.effect, term.channel
    if term.is_force:
        return _line_of_held_mass(decays, found, term) if effect.line else 0.0
    if not isinstance(effect, SensorFault) or not effect.shows_at_rest:
        return 0.0
    total = 0.0
    for i, prepared in enumerate(decays):
        if prepared.rest is None or channel not in prepared.rest.readings:
            continue
        values = found.of(term, i)
        p = np.array([values[q.name].value for q in effect.parameters])
        readings = prepared.rest.readings[channel]
        still = readings - readings.mean()
        fault = effect.observe(prepared.rest.time, np.zeros(len(readings)), p)
        left = still - (fault - fault.mean())
        sigma = max(found.windows[i].sigma[channel], float(np.std(left)) * 0.5)
        total += 0.5 * float(still @ still - left @ left) / sigma**2
    return total


def _line_of_held_mass(decays: tuple[PreparedDecay, ...], found: Fit, term: Term) -> float:
    """Return the evidence, below 0, against a force at the frequency of a line that a sensor shows at rest."""
    name = next(p.name for p in term.effect.parameters if p.unit == "Hz")
    frequency = found.of(term)[name].value
    against = 0.0
    for prepared in decays:
        for colour in prepared.rest_colour.values():
            for line in colour.lines:
                if abs(line.frequency - frequency) < CLEAR * line.uncertainty:
                    against += 0.5 * line.power * len(colour.left)
    return -against
