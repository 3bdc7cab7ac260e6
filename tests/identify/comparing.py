"""Releases with a known hidden effect, fitted with the model that lacks it, for the tests of the comparison."""

from functools import cache
from typing import Any

from identify.comparison.compare import Comparison, compare
from identify.fitting.fit import Fit, fit
from identify.fitting.initial_values import initial_values
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.noise import noise_of
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

MASS = 21.36


@cache
def fitted(
    effect: str | None, strength: float, seed: int
) -> tuple[PreparedDecay, Fit, dict[str, Any], dict[str, Any]]:
    """Return the setting, the fit of stiffness and friction, the noise of each channel and the truth."""
    sample = draw(effect, strength, seed)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    prepared = prepare(decay)
    model = base_model()
    found = fit(model, (prepared.window,), initial_values((prepared,), model, {}), prepared.frequency)
    return prepared, found, noise_of(decay), sample.truth


@cache
def compared(effect: str | None, strength: float, seed: int) -> Comparison:
    """Return the comparison of the same, with the testbed's mass."""
    prepared, found, floor, _ = fitted(effect, strength, seed)
    return compare(prepared, found, floor, mass=MASS)
