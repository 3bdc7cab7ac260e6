"""Releases of another bench: their stiffness is another by so much that no error of a fit explains it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from identify.effects.force_effect import LinearPart
from identify.fitting.initial_values import initial_values
from identify.fitting.segments import part_of
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay

_OTHER_BENCH = 1.3
"""Factor between two stiffnesses per mass, at like amplitudes, from which on the benches are plainly different: on 11 rigs
it is 1.07 at most."""

_STEEPER = 4.0
"""Multiple of the change of stiffness with amplitude within a release by which it may change between two that never meet."""

_LEAST_FALL = 0.3
"""Fall of the logarithm of the amplitude below which a change of stiffness within a release is noise."""


@dataclass(frozen=True)
class _Half:
    """A part of a release: its stiffness by equation error, 1/s^2, and the logarithm of its amplitude."""

    stiffness: float
    size: float


def other_benches(decays: Sequence[PreparedDecay]) -> tuple[int, ...]:
    """Return the places of the releases whose stiffness differs from the first's by more than that factor.

    That holds however large its error, unless the stiffness changes as far within a release, or so steeply that it may
    differ as much at an amplitude that the other release never reaches.
    """
    first, *others = [_halves_of(prepared) for prepared in decays]
    return tuple(i for i, other in enumerate(others, 1) if _far(first, other))


def _far(first: Sequence[_Half], other: Sequence[_Half]) -> bool:
    soft, stiff = sorted((first, other), key=lambda halves: min(half.stiffness for half in halves))
    low, high = max(half.stiffness for half in soft), min(half.stiffness for half in stiff)
    small, large = sorted((first, other), key=lambda halves: halves[0].size)
    apart = max(large[-1].size - small[0].size, 0.0)
    return bool(high > _OTHER_BENCH * low * np.exp(_STEEPER * apart * max(map(_slope, (first, other)))))


def _slope(halves: Sequence[_Half]) -> float:
    """Return the change of the logarithm of the stiffness with that of the amplitude."""
    early, late = halves
    return abs(float(np.log(early.stiffness / late.stiffness))) / max(early.size - late.size, _LEAST_FALL)


def _halves_of(prepared: PreparedDecay) -> list[_Half]:
    """Return the two halves of a release."""
    middle, model = len(prepared.window) // 2, base_model()
    parts = [part_of(prepared, samples) for samples in (slice(middle), slice(middle, len(prepared.window)))]
    name = str(model.linear_strength(LinearPart.STIFFNESS))
    return [
        _Half(initial_values((part,), model, {})[name], float(np.log(np.std(part.motion.displacement))))
        for part in parts
    ]
