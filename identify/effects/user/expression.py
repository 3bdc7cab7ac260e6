"""Expressions: a force written as a formula, parsed and never evaluated by Python.

Only numbers, names, + - * / **, parentheses and a few functions are understood. What is read becomes a tree of the five
nodes below, which can hold nothing else.
"""

import ast
import re
import warnings
from dataclasses import dataclass, field
from math import pi

LONGEST = 400
DEEPEST = 100
LARGEST_NUMBER = 1e30
LARGEST_POWER = 12.0

OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
}
FUNCTIONS = {
    "sin": 1,
    "cos": 1,
    "tan": 1,
    "tanh": 1,
    "exp": 1,
    "log": 1,
    "sqrt": 1,
    "abs": 1,
    "sgn": 1,
    "sign": 1,
    "min": 2,
    "max": 2,
    "clip": 3,
}
"""What may be called, and with how many arguments; `sign` is another name of `sgn`."""

CONSTANTS = {"pi": pi}

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


@dataclass(frozen=True)
class Number:
    """A constant."""

    value: float


@dataclass(frozen=True)
class Name:
    """A variable or a parameter; `at` is its place in the text, from 1."""

    name: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Negative:
    """A change of sign."""

    of: "Node"


@dataclass(frozen=True)
class Binary:
    """One of + - * / ** between two nodes."""

    operator: str
    left: "Node"
    right: "Node"


@dataclass(frozen=True)
class Call:
    """One of the functions with its arguments; `at` is its place in the text, from 1."""

    function: str
    arguments: "tuple[Node, ...]"
    at: int = field(default=0, compare=False)


Node = Number | Name | Negative | Binary | Call
ZERO = Number(0.0)


def parse_expression(text: str, *, before: int = 0) -> Node:
    """Return the tree of a formula.

    `before` is how many characters of what the user typed stand before it. Raises ValueError, in a sentence with the
    place in what the user typed, when it holds anything else than a formula.
    """
    indent = len(text) - len(text.lstrip())
    formula = re.sub(r"\s", " ", text.strip())
    before += indent
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
    return _node(tree, before + 1, 0)


def _node(found: ast.expr, first: int, depth: int) -> Node:
    at = first + found.col_offset
    if depth > DEEPEST:
        raise ValueError(f"character {at}: the formula is nested more than {DEEPEST} deep")
    if isinstance(found, ast.Constant):
        return _number(found.value, at)
    if isinstance(found, ast.Name):
        return Number(CONSTANTS[found.id]) if found.id in CONSTANTS else Name(found.id, at)
    if isinstance(found, ast.UnaryOp) and isinstance(found.op, ast.USub | ast.UAdd):
        operand = _node(found.operand, first, depth + 1)
        return Negative(operand) if isinstance(found.op, ast.USub) else operand
    if isinstance(found, ast.BinOp) and type(found.op) in OPERATORS:
        left, right = _node(found.left, first, depth + 1), _node(found.right, first, depth + 1)
        if isinstance(found.op, ast.Pow):
            _check_power(right, first + found.right.col_offset)
        return Binary(OPERATORS[type(found.op)], left, right)
    if isinstance(found, ast.Call) and isinstance(found.func, ast.Name):
        return _call(found, found.func.id, first, depth, at)
    raise ValueError(
        f"character {at}: only numbers, names, + - * / ** and the functions {', '.join(FUNCTIONS)} may stand in a formula"
    )


def _number(value: object, at: int) -> Number:
    if isinstance(value, bool) or not isinstance(value, int | float) or abs(value) > LARGEST_NUMBER:
        raise ValueError(f"character {at}: '{str(value)[:20]}' is not a number that can be used here")
    return Number(float(value))


def _call(found: ast.Call, name: str, first: int, depth: int, at: int) -> Call:
    if name not in FUNCTIONS:
        raise ValueError(
            f"character {at}: there is no function '{name[:20]}'; there are {', '.join(FUNCTIONS)}"
            + (" (multiplication is written *)" if len(name) <= 2 else "")
        )
    if found.keywords:
        raise ValueError(f"character {at}: {name} takes plain arguments, without = or **")
    wanted, given = FUNCTIONS[name], len(found.args)
    if given != wanted:
        raise ValueError(
            f"character {at}: {name} takes {wanted} argument{'s' if wanted > 1 else ''}, not {given}"
        )
    arguments = tuple(_node(argument, first, depth + 1) for argument in found.args)
    return Call("sgn" if name == "sign" else name, arguments, at)


def _check_power(power: Node, at: int) -> None:
    value = constant_of(power)
    if value is not None and not abs(value) <= LARGEST_POWER:
        raise ValueError(f"character {at}: powers above {LARGEST_POWER:g} are not read")


def constant_of(node: Node) -> float | None:
    """Return the value of a tree without names, functions left out; None where it has one, NaN where it has no value."""
    if isinstance(node, Number):
        return node.value
    if isinstance(node, Negative):
        value = constant_of(node.of)
        return None if value is None else -value
    if not isinstance(node, Binary):
        return None
    left, right = constant_of(node.left), constant_of(node.right)
    if left is None or right is None:
        return None
    try:
        return _combined(node.operator, left, right)
    except ArithmeticError:
        return float("nan")


def _combined(operator: str, left: float, right: float) -> float:
    if operator == "+":
        return left + right
    if operator == "-":
        return left - right
    if operator == "*":
        return left * right
    value = left / right if operator == "/" else left**right
    return value if isinstance(value, float) else float("nan")


def children_of(node: Node) -> tuple[Node, ...]:
    """Return the nodes right below one."""
    if isinstance(node, Negative):
        return (node.of,)
    if isinstance(node, Binary):
        return node.left, node.right
    return node.arguments if isinstance(node, Call) else ()


def walk(node: Node) -> tuple[Node, ...]:
    """Return all nodes of a tree, in the order of the text."""
    if isinstance(node, Binary):
        return (*walk(node.left), node, *walk(node.right))
    return (node, *(below for child in children_of(node) for below in walk(child)))


def names_in(node: Node) -> tuple[str, ...]:
    """Return the names of a tree in the order of their first use."""
    return tuple(dict.fromkeys(found.name for found in walk(node) if isinstance(found, Name)))


def is_slip_direction(node: Node) -> bool:
    """Whether a node is sgn(v)."""
    return isinstance(node, Call) and node.function == "sgn" and node.arguments == (Name("v"),)


def slipping(node: Node, direction: float) -> Node:
    """Return the tree with every sgn(v) replaced by a direction of slip, 1 or -1."""
    if is_slip_direction(node):
        return Number(direction)
    if isinstance(node, Negative):
        return Negative(slipping(node.of, direction))
    if isinstance(node, Binary):
        return Binary(node.operator, slipping(node.left, direction), slipping(node.right, direction))
    if isinstance(node, Call):
        return Call(node.function, tuple(slipping(a, direction) for a in node.arguments), node.at)
    return node


def times(first: Node, second: Node) -> Node:
    """Return the product of two trees."""
    return Binary("*", first, second)


def plus(first: Node, second: Node) -> Node:
    """Return the sum of two trees; nothing is added to zero."""
    if first == ZERO:
        return second
    return first if second == ZERO else Binary("+", first, second)


def minus(first: Node, second: Node) -> Node:
    """Return the difference of two trees."""
    return Binary("-", first, second)
