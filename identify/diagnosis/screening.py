"""Screening: which two effects together explain most of what a model leaves, by equation error.

Two effects may hide each other, so that neither looks good alone. Along the measured motion each is a column, and all
pairs of columns cost no more than a few milliseconds; only the best are worth a fit.
"""

from itertools import combinations

import numpy as np

from identify.arrays import Array
from identify.effects.effect import Scales
from identify.fitting.initial_values import term_starts
from identify.model.measured_path import force_along
from identify.model.model import Model, Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay

_INDEPENDENT = 1e-6
"""Share of a column that the model and the other column must leave free."""


def promising_pairs(
    prepared: PreparedDecay, model: Model, terms: tuple[Term, ...], scales: Scales
) -> tuple[tuple[str, str], ...]:
    """Return the pairs of effects by name, the one that leaves least of the restoring force first.

    Each effect is tried at all starting values of its inner parameters; strengths are free and of either sign.
    Faults of sensors are no forces, and are left out.
    """
    names, columns = _columns(prepared, terms, scales)
    if len(columns) < 2:
        return ()
    used = moving(prepared.motion)
    _, known = _columns(prepared, model.forces, scales)
    basis = np.linalg.qr(np.column_stack([*known, np.ones(len(used))])[used])[0]
    design = _unit(np.column_stack(columns)[used])
    free = design - basis @ (basis.T @ design)
    size = np.linalg.norm(free, axis=0)
    free = np.where(size > _INDEPENDENT, free / np.maximum(size, _INDEPENDENT), 0.0)
    left = prepared.restoring[used] - basis @ (basis.T @ prepared.restoring[used])
    explained = _explained_by_two(free.T @ left, free.T @ free)
    best: dict[tuple[str, str], float] = {}
    for i, j in combinations(range(len(names)), 2):
        if names[i] != names[j]:
            pair = (names[i], names[j]) if names[i] < names[j] else (names[j], names[i])
            best[pair] = max(best.get(pair, 0.0), float(explained[i, j]))
    return tuple(sorted(best, key=lambda pair: -best[pair]))


def _columns(
    prepared: PreparedDecay, terms: tuple[Term, ...], scales: Scales
) -> tuple[list[str], list[Array]]:
    """Return the finite forces of unit strength along the motion, (n,) each, and the names of their effects."""
    motion = prepared.motion
    names, columns = [], []
    for term in (term for term in terms if term.is_force):
        for inner in term_starts(term, scales):
            along = (prepared.time, motion.displacement, motion.velocity, prepared.frequency)
            force = force_along(term, inner, *along)
            if np.isfinite(force).all():
                names.append(term.effect.name)
                columns.append(force)
    return names, columns


def _unit(columns: Array) -> Array:
    return np.asarray(columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300))


def _explained_by_two(alone: Array, overlap: Array) -> Array:
    """Return the sum of squares that each two columns of unit length explain together, (columns, columns)."""
    apart = 1.0 - overlap**2
    both = alone[:, None] ** 2 + alone[None, :] ** 2 - 2.0 * overlap * np.outer(alone, alone)
    return np.where(apart > _INDEPENDENT, both / np.maximum(apart, _INDEPENDENT), 0.0)
