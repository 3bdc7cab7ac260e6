"""Releases of the testbed's double, made ready for the diagnosis, and their truth."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

HIDDEN = Path(__file__).resolve().parents[1] / "data" / "hidden"


def drawn(
    effect: str | None, strength: float, seed: int, **fixed: Any
) -> tuple[PreparedDecay, dict[str, Any]]:
    sample = draw(effect, strength, seed, **fixed)
    return ready(sample.rate, sample.displacement, sample.acceleration), sample.truth


def ready(rate: float, displacement: np.ndarray, acceleration: np.ndarray | None) -> PreparedDecay:
    return prepare(FreeDecay(rate, displacement, acceleration))


def hidden(name: str) -> tuple[PreparedDecay, dict[str, Any]]:
    rows = np.loadtxt(HIDDEN / f"{name}.csv", delimiter=",", skiprows=1)
    truth = next(t for t in json.loads((HIDDEN / "truth.json").read_text()) if t["file"] == f"{name}.csv")
    return ready(256.0, rows[:, 1], rows[:, 2]), truth
