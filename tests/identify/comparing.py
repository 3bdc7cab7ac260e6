"""Releases with a known hidden effect, fitted with the model that lacks it, for the tests of the comparison."""

from functools import cache
from typing import Any

from identify.comparison.compare import Comparison, compare_fitted
from identify.fitting.baseline import Baseline, fit_baseline
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

MASS = 21.36


@cache
def fitted(effect: str | None, strength: float, seed: int) -> tuple[Baseline, dict[str, Any]]:
    """Return the fit of stiffness and friction with its floor, and the truth."""
    sample = draw(effect, strength, seed)
    prepared = prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration, mass=MASS))
    return fit_baseline((prepared,), base_model()), sample.truth


@cache
def compared(effect: str | None, strength: float, seed: int) -> Comparison:
    """Return the comparison of the same, with the testbed's mass."""
    return compare_fitted(fitted(effect, strength, seed)[0])
