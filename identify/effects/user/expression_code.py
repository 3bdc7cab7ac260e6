"""Code for expressions: a tree compiled by numba, or worked out over arrays."""

import ast
from collections.abc import Callable, Mapping
from math import cos, exp, log, sin, sqrt, tan, tanh
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.compilation import compiled
from identify.effects.user.expression import Call, Name, Negative, Node, Number


@compiled("f8(f8)", error_model="numpy")
def _sgn(x):  # type: ignore[no-untyped-def]
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


@compiled("f8(f8,f8,f8)", error_model="numpy")
def _clip(x, low, high):  # type: ignore[no-untyped-def]
    return min(max(x, low), high)


_COMPILED: dict[str, Callable[..., float]] = {
    "sin": sin,
    "cos": cos,
    "tan": tan,
    "tanh": tanh,
    "exp": exp,
    "log": log,
    "sqrt": sqrt,
    "abs": abs,
    "sgn": _sgn,
    "min": min,
    "max": max,
    "clip": _clip,
}
_OVER_ARRAYS: dict[str, Callable[..., Any]] = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "tanh": np.tanh,
    "exp": np.exp,
    "log": np.log,
    "sqrt": np.sqrt,
    "abs": np.abs,
    "sgn": np.sign,
    "min": np.minimum,
    "max": np.maximum,
    "clip": np.clip,
}
_PYTHON: dict[str, ast.operator] = {
    "+": ast.Add(),
    "-": ast.Sub(),
    "*": ast.Mult(),
    "/": ast.Div(),
    "**": ast.Pow(),
}


def over_arrays(node: Node, values: Mapping[str, Array | float]) -> Any:
    """Return what a tree gives at values of its names, arrays or numbers; NaN or inf where it has no value."""
    with np.errstate(all="ignore"):
        return _worked_out(node, values)


def _worked_out(node: Node, values: Mapping[str, Array | float]) -> Any:
    if isinstance(node, Number):
        return np.float64(node.value)
    if isinstance(node, Name):
        return np.asarray(values[node.name], dtype=np.float64)
    if isinstance(node, Negative):
        return -_worked_out(node.of, values)
    if isinstance(node, Call):
        return _OVER_ARRAYS[node.function](*(_worked_out(a, values) for a in node.arguments))
    left, right = _worked_out(node.left, values), _worked_out(node.right, values)
    if node.operator == "+":
        return left + right
    if node.operator == "-":
        return left - right
    if node.operator == "*":
        return left * right
    return left / right if node.operator == "/" else left**right


def python_function(nodes: tuple[Node, ...], parameters: tuple[str, ...]) -> Callable[..., Any]:
    """Return a function (t, u, v, z, p) for numba to compile: a number for one tree, a tuple for two.

    Its source is made of the trees' nodes and nothing else.
    """
    places: dict[str, ast.expr] = {name: _item("p", i) for i, name in enumerate(parameters)}
    places |= {"z0": _item("z", 0), "z1": _item("z", 1)}
    places |= {name: ast.Name(name, ast.Load()) for name in ("t", "u", "v")}
    bodies = [_python(node, places) for node in nodes]
    result = bodies[0] if len(bodies) == 1 else ast.Tuple(bodies, ast.Load())
    arguments = ast.arguments([], [ast.arg(n) for n in ("t", "u", "v", "z", "p")], None, [], [], None, [])
    function = ast.FunctionDef("formula", arguments, [ast.Return(result)], [], None, None)
    module = ast.fix_missing_locations(ast.Module([function], []))
    scope: dict[str, Any] = {"__builtins__": {}} | _COMPILED
    exec(compile(module, "<formula>", "exec"), scope)  # made of the nodes above, never of the user's text
    made: Callable[..., Any] = scope["formula"]
    return made


def _python(node: Node, places: Mapping[str, ast.expr]) -> ast.expr:
    if isinstance(node, Number):
        return ast.Constant(node.value)
    if isinstance(node, Name):
        return places[node.name]
    if isinstance(node, Negative):
        return ast.UnaryOp(ast.USub(), _python(node.of, places))
    if isinstance(node, Call):
        return ast.Call(ast.Name(node.function, ast.Load()), [_python(a, places) for a in node.arguments], [])
    right = _python(node.right, places)
    if node.operator == "**" and isinstance(node.right, Number) and node.right.value.is_integer():
        right = ast.Constant(int(node.right.value))
    return ast.BinOp(_python(node.left, places), _PYTHON[node.operator], right)


def _item(name: str, place: int) -> ast.expr:
    return ast.Subscript(ast.Name(name, ast.Load()), ast.Constant(place), ast.Load())
