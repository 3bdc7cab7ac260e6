"""Expressions: a force written as a formula, parsed and never evaluated by Python.

Only numbers, the names given, + - * / **, parentheses and a few functions are understood. The tree is rebuilt node by
node from these, and what is compiled is that tree.
"""

import ast
from collections.abc import Callable, Iterable
from math import cos, exp, log, sin, sqrt, tan, tanh
from typing import Any

from numba import njit

_LONGEST = 400
_DEEPEST = 40
_LARGEST_POWER = 12.0
_OPERATORS = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)


@njit(error_model="numpy")
def _sgn(x):  # type: ignore[no-untyped-def]
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


@njit(error_model="numpy")
def _clip(x, low, high):  # type: ignore[no-untyped-def]
    return min(max(x, low), high)


FUNCTIONS: dict[str, tuple[Callable[..., float], int]] = {
    "sin": (sin, 1),
    "cos": (cos, 1),
    "tan": (tan, 1),
    "tanh": (tanh, 1),
    "exp": (exp, 1),
    "log": (log, 1),
    "sqrt": (sqrt, 1),
    "abs": (abs, 1),
    "sgn": (_sgn, 1),
    "sign": (_sgn, 1),
    "min": (min, 2),
    "max": (max, 2),
    "clip": (_clip, 3),
}
"""What may be called, and with how many arguments."""


def parse_expression(text: str) -> ast.expr:
    """Return the tree of a formula, made of allowed nodes only; ValueError, saying where, when it holds anything else."""
    if len(text) > _LONGEST:
        raise ValueError(f"the expression has {len(text)} characters; at most {_LONGEST} are read")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        place = getattr(error, "offset", None)
        where = f" at character {place}" if place else ""
        raise ValueError(f"'{text.strip()}' is not a formula{where}") from error
    return _allowed(tree, 0)


def _allowed(node: ast.expr, depth: int) -> ast.expr:
    if depth > _DEEPEST:
        raise ValueError(f"the expression is nested more than {_DEEPEST} deep")
    where = f"at character {getattr(node, 'col_offset', 0) + 1}"
    if isinstance(node, ast.Constant):
        if isinstance(node.value, bool) or not isinstance(node.value, int | float) or abs(node.value) > 1e30:
            raise ValueError(f"{where}: '{str(node.value)[:20]}' is not a number that can be used here")
        return ast.Constant(float(node.value))
    if isinstance(node, ast.Name):
        return ast.Name(node.id, ast.Load())
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd):
        return ast.UnaryOp(type(node.op)(), _allowed(node.operand, depth + 1))
    if isinstance(node, ast.BinOp) and isinstance(node.op, _OPERATORS):
        left, right = _allowed(node.left, depth + 1), _allowed(node.right, depth + 1)
        power = right.value if isinstance(node.op, ast.Pow) and isinstance(right, ast.Constant) else 0.0
        if isinstance(power, float) and abs(power) > _LARGEST_POWER:
            raise ValueError(f"{where}: a power above {_LARGEST_POWER:g} is not a force anyone has met")
        return ast.BinOp(left, type(node.op)(), right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        name = node.func.id
        if name not in FUNCTIONS:
            raise ValueError(f"{where}: there is no function '{name}'; there are {', '.join(FUNCTIONS)}")
        if len(node.args) != FUNCTIONS[name][1]:
            raise ValueError(f"{where}: {name} takes {FUNCTIONS[name][1]} argument(s), not {len(node.args)}")
        return ast.Call(
            ast.Name(name, ast.Load()), [_allowed(argument, depth + 1) for argument in node.args], []
        )
    raise ValueError(f"{where}: only numbers, names, + - * / ** and functions may stand in a formula")


def names_in(tree: ast.expr) -> tuple[str, ...]:
    """Return the names of a tree in the order of their first use, functions left out."""
    called = {id(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)}
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Name) and id(node) not in called]
    found.sort(key=lambda node: ast.unparse(tree).find(node.id))
    return tuple(dict.fromkeys(node.id for node in found))


def with_slip_direction(tree: ast.expr, direction: float) -> ast.expr:
    """Return the tree with every sgn(v) replaced by a direction of slip."""

    class Replace(ast.NodeTransformer):
        def visit_Call(self, node: ast.Call) -> ast.expr:
            self.generic_visit(node)
            argument = node.args[0]
            if (
                isinstance(node.func, ast.Name)
                and node.func.id in ("sgn", "sign")
                and isinstance(argument, ast.Name)
            ):
                return ast.Constant(direction) if argument.id == "v" else node
            return node

    return Replace().visit(_copy(tree))  # type: ignore[no-any-return]


def combined(weights: Iterable[tuple[float, ast.expr]]) -> ast.expr:
    """Return a weighted sum of trees."""
    total: ast.expr = ast.Constant(0.0)
    for weight, tree in weights:
        total = ast.BinOp(total, ast.Add(), ast.BinOp(ast.Constant(weight), ast.Mult(), tree))
    return total


def compile_tree(trees: tuple[ast.expr, ...], parameters: tuple[str, ...]) -> Callable[..., Any]:
    """Return a Python function (t, u, v, z, p) of trees, for numba to compile: a number for one, a tuple for two."""
    places: dict[str, ast.expr] = {name: _item("p", i) for i, name in enumerate(parameters)}
    places |= {"z0": _item("z", 0), "z1": _item("z", 1)}

    class Place(ast.NodeTransformer):
        def visit_Name(self, node: ast.Name) -> ast.expr:
            return places.get(node.id, node)

    bodies = [Place().visit(_copy(tree)) for tree in trees]
    result = bodies[0] if len(bodies) == 1 else ast.Tuple(bodies, ast.Load())
    arguments = ast.arguments([], [ast.arg(n) for n in ("t", "u", "v", "z", "p")], None, [], [], None, [])
    function = ast.FunctionDef("force", arguments, [ast.Return(result)], [], None, None)
    module = ast.fix_missing_locations(ast.Module([function], []))
    scope: dict[str, Any] = {name: called for name, (called, _) in FUNCTIONS.items()}
    exec(compile(module, "<formula>", "exec"), scope)  # the tree holds nothing but the nodes built above
    made: Callable[..., Any] = scope["force"]
    return made


def _item(name: str, place: int) -> ast.expr:
    return ast.Subscript(ast.Name(name, ast.Load()), ast.Constant(place), ast.Load())


def _copy(tree: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(ast.fix_missing_locations(tree)), mode="eval").body
