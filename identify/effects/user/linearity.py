"""Proportion: which parameter of a formula is its strength, and whether the others can be told from it."""

from collections.abc import Callable
from typing import Literal

import numpy as np

from identify.arrays import Array
from identify.effects.user.expression import Binary, Call, Name, Negative, Node, Number

Order = Literal["absent", "zero", "linear", "positive", "other"]
"""How a force depends on a parameter; `positive` is proportional where the parameter is not negative."""

Values = Callable[[dict[str, float], dict[str, Array]], tuple[Array, ...]]
"""Force, friction level and rates of an effect at values of its parameters and of t, u, v, z0, z1, shape (n,) each."""

_POINTS = 400
_DRAWS = 6
_NUDGE = 1e-4
_LEAP = 0.5
_SAME = 1e-5
_SIZES = (1.0, 0.1, 0.01, 1e-3)


def order_in(node: Node, name: str) -> Order:
    """Return how a formula depends on a parameter, from its tree."""
    if isinstance(node, Number):
        return "zero" if node.value == 0.0 else "absent"
    if isinstance(node, Name):
        return "linear" if node.name == name else "absent"
    if isinstance(node, Negative):
        return order_in(node.of, name)
    if isinstance(node, Call):
        return _order_of_call(node, name)
    left, right = order_in(node.left, name), order_in(node.right, name)
    if node.operator in "+-":
        return _sum(left, right)
    return _order_of_product(node, left, right)


def _sum(left: Order, right: Order) -> Order:
    kinds = {left, right} - {"zero"}
    if len(kinds) <= 1:
        return kinds.pop() if kinds else "zero"
    return "positive" if kinds == {"linear", "positive"} else "other"


def _order_of_product(node: Binary, left: Order, right: Order) -> Order:
    if node.operator == "*":
        if "zero" in (left, right):
            return "zero"
        if right == "absent":
            return left
        return right if left == "absent" else "other"
    if node.operator == "/":
        return left if right == "absent" else "other"
    if left == right == "absent":
        return "absent"
    return left if node.right == Number(1.0) and right == "absent" else "other"


def _order_of_call(node: Call, name: str) -> Order:
    orders = {order_in(argument, name) for argument in node.arguments}
    if orders <= {"absent", "zero"}:
        return "absent"
    homogeneous = node.function in ("abs", "min", "max", "clip") and orders <= {"linear", "positive", "zero"}
    return "positive" if homogeneous else "other"


def strength_in(node: Node, names: tuple[str, ...]) -> tuple[str, Order]:
    """Return the first parameter to which a formula is proportional, and how; ("", "absent") where there is none."""
    orders = {name: order_in(node, name) for name in names}
    wanted: tuple[Order, ...] = ("linear", "positive")
    for order in wanted:
        for name in names:
            if orders[name] == order:
                return name, order
    return "", "absent"


def drawn_points(random: np.random.Generator, size: float) -> dict[str, Array]:
    """Return points (t, u, v, z0, z1), shape (n,) each, of magnitudes spread below `size`, t not negative."""
    points = {}
    for name in ("t", "u", "v", "z0", "z1"):
        magnitude = size * 10.0 ** random.uniform(-4.0, 0.0, _POINTS)
        points[name] = magnitude if name == "t" else magnitude * random.choice([-1.0, 1.0], _POINTS)
    return points


def check_values(name: str, values: Values, draw: Callable[[np.random.Generator], dict[str, float]]) -> None:
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
        raise ValueError(f"{name}: a constant force only moves the spring's zero, and cannot be told from it")


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


def acting_together(
    values: Values, draw: Callable[[np.random.Generator], dict[str, float]]
) -> tuple[str, ...]:
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
