"""A force that the user wrote as a Python function, made ready for the simulator."""

import ast
import inspect
import re
from collections.abc import Callable
from typing import Any

import numpy as np

import identify.compilation  # noqa: F401  numba is imported there, blind to the working folder

# isort: split
from numba import njit

from identify.arrays import Array

_VARIABLES = ("t", "u", "v")
_STATES = ("z0", "z1")
_TUPLES = ("t", "u", "v", "z", "p")


def parameters_of(function: Callable[..., float], listed: tuple[str, ...]) -> tuple[str, ...]:
    """Return the parameters of a function (t, u, v, [z0, z1,] parameters...), or those listed for (t, u, v, z, p).

    ValueError when its arguments are others.
    """
    arguments = tuple(inspect.signature(function).parameters)
    if arguments == _TUPLES:
        if not listed:
            raise ValueError("a function (t, u, v, z, p) needs its parameters listed, the strength first")
        return listed
    if arguments[:3] != _VARIABLES or len(arguments) < 4:
        raise ValueError(
            f"the function has the arguments ({', '.join(arguments)}); they must be t, u, v and then its parameters, "
            "the strength first"
        )
    return tuple(a for a in arguments[3:] if a not in _STATES)


def placed(function: Callable[..., float], names: tuple[str, ...]) -> Callable[..., float]:
    """Return the function as one of (t, u, v, z, p), for numba to compile; ValueError when numba cannot compile it."""
    arguments = tuple(inspect.signature(function).parameters)
    if arguments == _TUPLES:
        return function
    places = {name: f"p[{i}]" for i, name in enumerate(names)} | {"z0": "z[0]", "z1": "z[1]"}
    values = ", ".join(places.get(argument, argument) for argument in arguments)
    scope: dict[str, Any] = {"__builtins__": {}, "inner": njit(error_model="numpy")(function)}
    exec(compile(ast.parse(f"def outer(t, u, v, z, p): return inner({values})"), "<own>", "exec"), scope)
    made: Callable[..., float] = scope["outer"]
    return made


def compiled(compile_it: Callable[..., Any], function: Callable[..., float]) -> Any:
    """Return the function compiled; ValueError with numba's reason, in a line, when it cannot be."""
    try:
        return compile_it(function, cache=False)
    except Exception as error:  # numba's errors have no base of their own that is public
        raise ValueError(f"the function cannot be compiled: {reason_of(error)}") from error


def reason_of(error: Exception) -> str:
    """Shorten an error of numba: its first line with a reason, and the line of the source."""
    lines = [re.sub(r"\x1b\[\d+m", "", line).strip() for line in str(error).splitlines()]
    empty = ("Failed in", "During:", "[", "-", "Rejected", "There are", "- ")
    reasons = [line for line in lines if line and not line.startswith(empty)]
    places = re.findall(r'File "[^"]*", line (\d+)', "\n".join(lines))
    first = reasons[0] if reasons else type(error).__name__
    return f"{first} (line {places[-1]})" if places else first


def along(function: Any, count: int, points: dict[str, Array], p: dict[str, float]) -> Array:
    """Evaluate a compiled function at points (t, u, v, z0, z1), shape (n,)."""
    values = (*p.values(), *[0.0] * (count - len(p)))
    rows = zip(*(points[n] for n in ("t", "u", "v", "z0", "z1")), strict=True)
    return np.array([function(t, u, v, (z0, z1), values) for t, u, v, z0, z1 in rows])
