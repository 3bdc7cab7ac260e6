"""Proportion: which parameter of a force is its strength, and whether the others are distinguishable from it."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from identify.arrays import Array

Proportion = Literal["always", "from zero up", "no"]
"""For which values of a parameter a force is proportional to it."""

Values = Callable[[dict[str, float], dict[str, Array]], tuple[Array, ...]]
"""Force, friction level and rates of an effect at values of its parameters and of t, u, v, z0, z1, shape (n,) each."""

Draw = Callable[[np.random.Generator], dict[str, float]]

_POINTS = 400
_DRAWS = 6
_NUDGE = 1e-4
_LEAP = 0.5
_SAME = 1e-5
_SIZES = (1.0, 0.1, 0.01, 1e-3)


def proportion(values: Values, names: tuple[str, ...], name: str) -> Proportion:
    """Decide whether force and friction double, vanish and change sign with one of the parameters `names`."""
    random = np.random.default_rng(4)
    changes_sign, acts = True, False
    for _ in range(_DRAWS):
        p = {n: float(random.uniform(0.3, 2.0)) for n in names}
        points = points_near(random, p)
        once = np.concatenate(values(p, points)[:2])
        known = np.isfinite(once)
        acts |= bool(np.any(once[known]))
        for factor in (2.0, 0.0, -1.0):
            other = np.concatenate(values(p | {name: factor * p[name]}, points)[:2])
            if not np.allclose(other[known], factor * once[known], rtol=1e-9, atol=1e-300):
                if factor >= 0.0:
                    return "no"
                changes_sign = False
    return "no" if not acts else "always" if changes_sign else "from zero up"


def drawn_points(random: np.random.Generator, size: float) -> dict[str, Array]:
    """Return points (t, u, v, z0, z1), shape (n,) each, of magnitudes spread below `size`, t not negative."""
    points = {}
    for name in ("t", "u", "v", "z0", "z1"):
        magnitude = size * 10.0 ** random.uniform(-4.0, 0.0, _POINTS)
        points[name] = magnitude if name == "t" else magnitude * random.choice([-1.0, 1.0], _POINTS)
    return points


def check_values(name: str, values: Values, draw: Draw) -> None:
    """Check that an effect is finite around rest, on some scale at least, and depends on the motion or on time.

    Raises ValueError, with a point at which it fails.
    """
    random = np.random.default_rng(0)
    fault = ""
    for size in (*_SIZES, *_SIZES):
        points = {n: np.append(x, 0.0) for n, x in drawn_points(random, size).items()}
        wrong = np.flatnonzero(~np.all([np.isfinite(x) for x in values(draw(random), points)], axis=0))
        if not len(wrong):
            break
        fault = fault or _told(points, int(wrong[-1]))
    else:
        raise ValueError(f"{name}: {fault}")
    found = [values(p, points_near(random, p)) for p in (draw(random) for _ in range(_DRAWS))]
    forces = [np.where(np.isfinite(force), force, 0.0) for force, *_ in found]
    dry = any(np.nan_to_num(level).any() for _, level, *_ in found)
    if not dry and not any(force.any() for force in forces):
        raise ValueError(f"{name}: the force is zero everywhere")
    if not dry and not any(np.ptp(force) > 0.0 for force in forces):
        raise ValueError(
            f"{name}: a constant force only moves the spring's zero and cannot be distinguished from it"
        )


def points_near(random: np.random.Generator, p: dict[str, float]) -> dict[str, Array]:
    """Return drawn points, half of them at displacements and speeds of the parameters' own sizes."""
    points = drawn_points(random, 10.0)
    sizes = np.abs(list(p.values()))
    half = _POINTS // 2
    for name in ("u", "v"):
        centre = random.choice(sizes, half) * random.choice([-1.0, 0.0, 1.0], half)
        points[name][:half] = centre + random.choice(sizes, half) * random.uniform(-2.0, 2.0, half)
    points["t"][:half] = random.choice(sizes, half) * random.uniform(0.0, 3.0, half)
    return points


def _told(points: dict[str, Array], i: int) -> str:
    t, u, v = (points[n][i] for n in ("t", "u", "v"))
    return (
        f"at t = {t:.2g}, u = {u:.2g}, v = {v:.2g} it gives no number; a power of u that is not whole is written "
        "abs(u)**b*sgn(u), and v/abs(v) is sgn(v)"
    )


def acting_together(values: Values, draw: Draw) -> tuple[str, ...]:
    """Return parameters of which one could be left out: they act only together, or not at all; () where each counts."""
    random = np.random.default_rng(1)
    together: tuple[str, ...] = ()
    least = -1.0
    for _ in range(_DRAWS):
        p = draw(random)
        points = points_near(random, p)
        columns = np.array([_column(values, p, points, name) for name in p])
        columns = columns[:, np.isfinite(columns).all(axis=0)]
        largest = np.abs(columns).max(axis=1, initial=0.0)
        columns = columns / np.where(largest > 0.0, largest, 1.0)[:, None]  # squares of huge forces overflow
        sizes = np.linalg.norm(columns, axis=1)
        if sizes.all() and columns.shape[1] >= len(p):
            vectors, weights, _ = np.linalg.svd(columns / sizes[:, None], full_matrices=False)
            weakest, weight = float(weights[-1]), np.abs(vectors[:, -1])
        else:
            weakest, weight = 0.0, (sizes == 0.0).astype(float)
        if weakest > _SAME:
            return ()
        if weakest > least:
            least = weakest
            together = tuple(name for name, w in zip(p, weight, strict=True) if w > 0.1)
    return together


def _column(values: Values, p: dict[str, float], points: dict[str, Array], name: str) -> Array:
    """Return the change of everything an effect gives with the logarithm of one parameter, shape (k n,).

    Where a small change does nothing, as at the place of a step, a large one is taken.
    """
    change = np.zeros(0)
    for nudge in (_NUDGE, _LEAP):
        above = values(p | {name: p[name] * (1.0 + nudge)}, points)
        below = values(p | {name: p[name] * (1.0 - nudge)}, points)
        with np.errstate(all="ignore"):
            change = np.concatenate([(a - b) / (2.0 * nudge) for a, b in zip(above, below, strict=True)])
        if change.any():
            break
    return change
