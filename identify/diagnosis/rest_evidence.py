"""Evidence at rest: a hum is there before the release, a force that shakes the mass is not seen while it is held."""

import numpy as np

from identify.diagnosis.suspects import Candidate
from identify.effects.sensor_fault import SensorFault
from identify.preprocessing.prepared_decay import PreparedDecay

DENIED = -6.0
"""Nats below which the rest rules a candidate out."""

_SAME = 4.0
"""Standard errors within which two frequencies are one."""


def at_rest(decays: tuple[PreparedDecay, ...], candidate: Candidate) -> float:
    """Return how much better a sensor's fault explains the rest before the release than a constant, in nats.

    Negative where the fault ought to show at rest and does not, and for a force whose line a sensor shows while the mass is
    held; 0 for everything that says nothing of the rest.
    """
    effect, channel = candidate.term.effect, candidate.term.channel
    if candidate.term.is_force:
        return _line_of_held_mass(decays, candidate) if effect.line else 0.0
    if not isinstance(effect, SensorFault) or not effect.shows_at_rest:
        return 0.0
    total = 0.0
    for i, prepared in enumerate(decays):
        if prepared.rest is None or channel not in prepared.rest.readings:
            continue
        found = candidate.fit.of(candidate.term, i)
        p = np.array([found[q.name].value for q in effect.parameters])
        readings = prepared.rest.readings[channel]
        still = readings - readings.mean()
        fault = effect.observe(prepared.rest.time, np.zeros(len(readings)), p)
        left = still - (fault - fault.mean())
        sigma = max(candidate.fit.windows[i].sigma[channel], float(np.std(left)) * 0.5)
        total += 0.5 * float(still @ still - left @ left) / sigma**2
    return total


def denied(decays: tuple[PreparedDecay, ...], candidate: Candidate) -> bool:
    """Whether the rest rules a candidate out."""
    return at_rest(decays, candidate) < DENIED


def _line_of_held_mass(decays: tuple[PreparedDecay, ...], candidate: Candidate) -> float:
    """Return the evidence, below 0, against a line of a force at a frequency that stands in a sensor's rest."""
    name = next(p.name for p in candidate.term.effect.parameters if p.unit == "Hz")
    frequency = candidate.fit.of(candidate.term)[name].value
    against = 0.0
    for prepared in decays:
        for colour in prepared.rest_colour.values():
            for line in colour.lines:
                if abs(line.frequency - frequency) < _SAME * line.uncertainty:
                    against += 0.5 * line.power * len(colour.left)
    return -against
