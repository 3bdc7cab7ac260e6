"""Formulas: a force as the user writes it, parsed by Python and never evaluated as it was typed.

Only numbers, names, + - * / **, parentheses and a few functions may stand in it. What is run is made of these, each name
replaced by its place among the arguments (t, u, v, z, p) of the simulator.
"""

import ast
import math
import re
import warnings
from collections.abc import Callable, Mapping
from copy import deepcopy
from typing import Any, TypeGuard

import numpy as np

from identify.compilation import compiled

LONGEST = 400
DEEPEST = 100
LARGEST_NUMBER = 1e30
LARGEST_POWER = 12.0


@compiled("f8(f8)", error_model="numpy")
def _sgn(x):  # type: ignore[no-untyped-def]
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


@compiled("f8(f8,f8,f8)", error_model="numpy")
def _clip(x, low, high):  # type: ignore[no-untyped-def]
    return min(max(x, low), high)


_SAME_NAME = ("sin", "cos", "tan", "tanh", "exp", "log", "sqrt")
FUNCTIONS: dict[str, tuple[int, Callable[..., Any], Callable[..., Any]]] = {
    **{name: (1, getattr(math, name), getattr(np, name)) for name in _SAME_NAME},
    "abs": (1, abs, np.abs),
    "sgn": (1, _sgn, np.sign),
    "sign": (1, _sgn, np.sign),
    "min": (2, min, np.minimum),
    "max": (2, max, np.maximum),
    "clip": (3, _clip, np.clip),
}
"""What may be called: with how many arguments, what numba compiles for it, and what does it over arrays."""

CONSTANTS = {"pi": math.pi}
ZERO = ast.Constant(0.0)
_NUMBER = "number of NumPy"
"""A name that nobody can write in a formula."""

_STRANGE = re.compile(r"[^A-Za-z0-9_+\-*/(),.\s]")
_ADVICE = {
    "^": "a power is written **",
    "=": "the formula stands after the first '=', and holds no other",
    "<": "for a force on one side write max(u, 0), for a step (1 + sgn(u))/2",
    ">": "for a force on one side write max(u, 0), for a step (1 + sgn(u))/2",
    "|": "an absolute value is written abs(u)",
    "−": "write the minus sign as -",
    "·": "multiplication is written *",
    "×": "multiplication is written *",
    "²": "a square is written **2",
    "³": "a cube is written **3",
}


def parse_formula(text: str, *, before: int = 0) -> ast.expr:
    """Parse and check a formula; the `col_offset` of names and calls is their place in what the user typed, from 1.

    `before` is how many characters of what the user typed stand before it. Raises ValueError, in a sentence with the
    place in what the user typed, when it holds anything else than a formula.
    """
    before += len(text) - len(text.lstrip())
    formula = re.sub(r"\s", " ", text.strip())
    if not formula:
        raise ValueError(f"character {before + 1}: a formula is missing here, such as a*u/(1 + (u/b)**2)")
    if len(formula) > LONGEST:
        raise ValueError(f"the formula has {len(formula)} characters; at most {LONGEST} are read")
    strange = _STRANGE.search(formula)
    if strange is not None:
        letter = strange.group()
        advice = _ADVICE.get(
            letter, "a formula is made of numbers, names, + - * / **, parentheses and commas"
        )
        raise ValueError(f"character {before + strange.start() + 1}: '{letter}' cannot be read; {advice}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            tree = ast.parse(formula, mode="eval").body
    except SyntaxError as error:
        raise ValueError(
            f"character {before + (error.offset or 1)}: the formula cannot be read ({error.msg})"
        ) from error
    except (ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"character {before + 1}: the formula cannot be read") from error
    return _checked(tree, before + 1, 0)


def _checked(node: ast.expr, first: int, depth: int) -> ast.expr:
    """Rebuild a tree from the kinds of nodes that are allowed; all numbers become floats, but whole powers."""
    at = first + node.col_offset

    def below(part: ast.expr) -> ast.expr:
        return _checked(part, first, depth + 1)

    if depth > DEEPEST:
        raise ValueError(f"character {at}: the formula is nested more than {DEEPEST} deep")
    match node:
        case ast.Constant(value=value):
            if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > LARGEST_NUMBER:
                raise ValueError(f"character {at}: '{str(value)[:20]}' is not a number that can be used here")
            return ast.Constant(float(value))
        case ast.Name(id=name):
            return (
                ast.Constant(CONSTANTS[name])
                if name in CONSTANTS
                else ast.Name(name, ast.Load(), col_offset=at)
            )
        case ast.UnaryOp(op=ast.USub() | ast.UAdd() as sign, operand=operand):
            return ast.UnaryOp(sign, below(operand))
        case ast.BinOp(left=left, op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div() as operator, right=right):
            return ast.BinOp(below(left), operator, below(right))
        case ast.BinOp(left=left, op=ast.Pow() as operator, right=right):
            return ast.BinOp(below(left), operator, _power(below(right), first + right.col_offset))
        case ast.Call(func=ast.Name(id=name)):
            _check_call(node, name, at)
            return ast.Call(
                ast.Name(name, ast.Load()), [below(part) for part in node.args], [], col_offset=at
            )
    raise ValueError(
        f"character {at}: only numbers, names, + - * / ** and the functions {', '.join(FUNCTIONS)} may stand in a formula"
    )


def _check_call(call: ast.Call, name: str, at: int) -> None:
    if name not in FUNCTIONS:
        raise ValueError(
            f"character {at}: there is no function '{name[:20]}'; there are {', '.join(FUNCTIONS)}"
            + (" (multiplication is written *)" if len(name) <= 2 else "")
        )
    if call.keywords:
        raise ValueError(f"character {at}: {name} takes plain arguments, without = or **")
    wanted, given = FUNCTIONS[name][0], len(call.args)
    if given != wanted:
        raise ValueError(
            f"character {at}: {name} takes {wanted} argument{'s' if wanted > 1 else ''}, not {given}"
        )


def _power(power: ast.expr, at: int) -> ast.expr:
    """Refuse a constant power that is too large; a whole number is one that numba multiplies."""
    if not any(isinstance(node, ast.Name) for node in ast.walk(power)):
        value = float(over_arrays((power,), ())(0.0, 0.0, 0.0, (0.0, 0.0), ())[0])
        if not abs(value) <= LARGEST_POWER:
            raise ValueError(f"character {at}: powers above {LARGEST_POWER:g} are not read")
    if isinstance(power, ast.Constant) and isinstance(power.value, float) and power.value.is_integer():
        return ast.Constant(int(power.value))
    return power


def names_in(tree: ast.expr) -> list[ast.Name]:
    """List the names of variables and parameters in a formula, in the order of its text."""
    nodes = list(ast.walk(tree))
    called = [node.func for node in nodes if isinstance(node, ast.Call)]
    found = [node for node in nodes if isinstance(node, ast.Name) and node not in called]
    return sorted(found, key=lambda node: node.col_offset)


def is_sign(node: ast.AST) -> TypeGuard[ast.Call]:
    """Check whether a node is sgn(...)."""
    return isinstance(node, ast.Call) and getattr(node.func, "id", "") in ("sgn", "sign")


def is_slip_direction(node: ast.AST) -> bool:
    """Check whether a node is sgn(v)."""
    return is_sign(node) and getattr(node.args[0], "id", "") == "v"


def slipping(formula: ast.expr) -> tuple[ast.expr, ast.expr] | None:
    """Split a formula into what does not depend on sgn(v) and the level that goes with it; None where it has none."""
    if not any(is_slip_direction(node) for node in ast.walk(formula)):
        return None
    forth, back = (_Rewritten(slip=slip).visit(deepcopy(formula)) for slip in (1.0, -1.0))
    smooth, level = ast.BinOp(forth, ast.Add(), back), ast.BinOp(forth, ast.Sub(), back)
    return times(ast.Constant(0.5), smooth), times(ast.Constant(0.5), level)


def times(first: ast.expr, second: ast.expr) -> ast.expr:
    """Multiply two formulas."""
    return ast.BinOp(first, ast.Mult(), second)


def to_compile(formulas: tuple[ast.expr, ...], parameters: tuple[str, ...]) -> Callable[..., Any]:
    """Make a function (t, u, v, z, p) for numba to compile, which gives a number for one formula, a tuple for two."""
    scope = {name: function for name, (_, function, _) in FUNCTIONS.items()}
    return _function(formulas, parameters, scope)


def over_arrays(formulas: tuple[ast.expr, ...], parameters: tuple[str, ...]) -> Callable[..., Any]:
    """Make the same function over arrays, which gives a tuple; NaN or inf where a formula has no value."""
    scope = {name: function for name, (_, _, function) in FUNCTIONS.items()}
    return np.errstate(all="ignore")(_function(formulas, parameters, scope | {_NUMBER: np.float64}))


def _function(
    formulas: tuple[ast.expr, ...], parameters: tuple[str, ...], scope: dict[str, Any]
) -> Callable[..., Any]:
    places = {name: f"p[{i}]" for i, name in enumerate(parameters)} | {"z0": "z[0]", "z1": "z[1]"}
    rewritten = _Rewritten(places, numbers=_NUMBER in scope)
    bodies = [rewritten.visit(deepcopy(formula)) for formula in formulas]
    module = ast.parse("def formula(t, u, v, z, p): return 0")
    definition = module.body[0]
    several = len(bodies) != 1 or _NUMBER in scope
    definition.body[0].value = ast.Tuple(bodies, ast.Load()) if several else bodies[0]  # type: ignore[attr-defined]
    for node in ast.walk(module):
        ast.copy_location(node, definition)
    known: dict[str, Any] = {"__builtins__": {}} | scope
    exec(compile(module, "<formula>", "exec"), known)  # made of checked nodes alone
    made: Callable[..., Any] = known["formula"]
    return made


class _Rewritten(ast.NodeTransformer):
    """Puts places among the arguments for names, a direction of slip for sgn(v), and NumPy's `numbers` for Python's."""

    def __init__(
        self, places: Mapping[str, str] | None = None, *, slip: float | None = None, numbers: bool = False
    ) -> None:
        self.places, self.slip, self.numbers = places or {}, slip, numbers

    def visit_Call(self, node: ast.Call) -> ast.expr:
        if self.slip is not None and is_slip_direction(node):
            return ast.Constant(self.slip)
        return ast.Call(node.func, [self.visit(argument) for argument in node.args], [])

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return ast.parse(self.places[node.id], mode="eval").body if node.id in self.places else node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if not self.numbers or isinstance(node.value, int):
            return node
        return ast.Call(ast.Name(_NUMBER, ast.Load()), [node], [])
