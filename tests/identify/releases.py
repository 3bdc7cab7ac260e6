"""Releases of the testbed's double, made ready for the diagnosis, and their truth."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

CALIBRATED = 2e-4
"""Relative uncertainty of the gain between the double's sensors, where a test takes them for calibrated ones."""

HIDDEN = Path(__file__).resolve().parents[1] / "data" / "hidden"


def drawn(
    effect: str | None, strength: float, seed: int, *, gain_uncertainty: float = 0.0, **fixed: Any
) -> tuple[PreparedDecay, dict[str, Any]]:
    sample = draw(effect, strength, seed, **fixed)
    decay = FreeDecay(sample.rate, sample.displacement, sample.acceleration)
    return prepare(decay, gain_uncertainty=gain_uncertainty), sample.truth


def ready(rate: float, displacement: np.ndarray, acceleration: np.ndarray | None) -> PreparedDecay:
    return prepare(FreeDecay(rate, displacement, acceleration))


def hidden(name: str) -> tuple[PreparedDecay, dict[str, Any]]:
    rows = np.loadtxt(HIDDEN / f"{name}.csv", delimiter=",", skiprows=1)
    truth = next(t for t in json.loads((HIDDEN / "truth.json").read_text()) if t["file"] == f"{name}.csv")
    return ready(256.0, rows[:, 1], rows[:, 2]), truth
