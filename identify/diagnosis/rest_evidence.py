"""Evidence at rest: a hum is there before the release, a force that shakes the mass is not seen while it is held."""

import numpy as np

from identify.diagnosis.suspects import Candidate
from identify.effects.sensor_fault import SensorFault
from identify.preprocessing.prepared_decay import PreparedDecay


def at_rest(decays: tuple[PreparedDecay, ...], candidate: Candidate) -> float:
    """Return how much better a sensor's fault explains the rest before the release than a constant, in nats.

    Negative where the fault ought to show at rest and does not; 0 for everything that says nothing of the rest.
    """
    effect, channel = candidate.term.effect, candidate.term.channel
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
