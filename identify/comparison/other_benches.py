"""Releases of another bench: their stiffness is another by so much that no error of a fit explains it."""

from collections.abc import Sequence

import numpy as np

from identify.effects.force_effect import LinearPart
from identify.fitting.initial_values import initial_values
from identify.fitting.segments import part_of
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay

_OTHER_BENCH, _NONLINEAR = 1.3, 2.0
"""Factor between two stiffnesses per mass from which on the benches are plainly different, at like amplitudes (on 11 rigs
it is 1.07 at most) and at unlike ones, between which a spring may harden."""

_LIKE = 1.5
"""Ratio of two amplitudes up to which they are alike."""

_FEWEST_CYCLES = 2.0


def other_benches(decays: Sequence[PreparedDecay]) -> tuple[int, ...]:
    """Return the places of the releases whose stiffness differs from the first's by more than that factor.

    However large its error, unless the stiffness drifts as far within a release.
    """
    ranges = [_stiffness_of(prepared) for prepared in decays]
    sizes = [prepared.amplitude for prepared in decays]
    alike = [max(size, sizes[0]) < _LIKE * min(size, sizes[0]) for size in sizes]
    limits = [_OTHER_BENCH if one else _NONLINEAR for one in alike]
    return tuple(i for i in range(1, len(ranges)) if _far(ranges[0], ranges[i], limits[i]))


def _far(first: tuple[float, float], other: tuple[float, float], limit: float) -> bool:
    (_, low), (high, _) = sorted((first, other))
    return high > limit * low


def _stiffness_of(prepared: PreparedDecay) -> tuple[float, float]:
    """Return the smallest and the largest stiffness, 1/s^2, of a decay and of its halves, by equation error."""
    n, model = len(prepared.window), base_model()
    parts = [prepared]
    if n // 2 / prepared.window.rate * prepared.frequency / (2.0 * np.pi) >= _FEWEST_CYCLES:
        parts += [part_of(prepared, slice(n // 2)), part_of(prepared, slice(n // 2, n))]
    name = str(model.linear_strength(LinearPart.STIFFNESS))
    found = [initial_values((part,), model, {})[name] for part in parts]
    return min(found), max(found)
