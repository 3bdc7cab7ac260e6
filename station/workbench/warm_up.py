"""Warming up: one small fit, so that the first click of the operator finds everything compiled."""

import numpy as np

from identify.comparison.compare import compare_fitted
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare

RATE, SECONDS, FREQUENCY, DECAY, AMPLITUDE = 256.0, 6.0, 25.0, 0.25, 0.02


def warm_up(*_: object) -> None:
    """Fit, extend and compare a decay in closed form with a little noise; a worker's task like the others."""
    draw = np.random.default_rng(1)
    time = np.arange(-RATE, RATE * SECONDS) / RATE
    moving = np.maximum(time, 0.0)
    shape = np.exp(-DECAY * moving) * AMPLITUDE
    u = shape * np.cos(FREQUENCY * moving) + 5e-6 * draw.standard_normal(len(time))
    a = np.where(time > 0, -(FREQUENCY**2) * shape * np.cos(FREQUENCY * moving), 0.0)
    a = a + 0.01 * draw.standard_normal(len(time))
    prepared = prepare(FreeDecay(rate=RATE, displacement=u, acceleration=a))
    friction = next(e for e in LIBRARY if isinstance(e, ForceEffect) and e.friction is not None and e.inner)
    step = add_effect(first_step((prepared,)), friction)
    compare_fitted(step.baseline)
