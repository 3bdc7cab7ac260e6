"""Calling a compiled effect by its address, so that a model is an array of addresses and never recompiles."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import identify.compilation  # noqa: F401  numba is imported there, blind to the working folder

# isort: split
from llvmlite import ir
from numba import njit, types
from numba.core.typing import signature
from numba.experimental.function_type import _get_wrapper_address
from numba.extending import intrinsic

from identify.compilation import compiled

STATES = 2
PARAMETERS = 6
_SCALAR = types.float64
STATE_TUPLE = types.UniTuple(_SCALAR, STATES)
_ARGUMENTS = (_SCALAR, _SCALAR, _SCALAR, STATE_TUPLE, types.UniTuple(_SCALAR, PARAMETERS))
FORCE = signature(_SCALAR, *_ARGUMENTS)
RATES = signature(STATE_TUPLE, *_ARGUMENTS)


def effect_function(function: Callable[..., Any], kind: Any = FORCE, *, cache: bool = True) -> Any:
    """Compile `function(t, u, v, z, p)` to a FORCE, or a friction level, per unit mass (m/s^2), or to RATES.

    `z` is a tuple of two internal states, of which RATES are the rates, `p` one of six parameters. What is kept on disk is
    loaded when it is first used; what is not is compiled at once, so that a formula that cannot be compiled is refused where
    it is given.
    """
    return compiled(error_model="numpy")(function) if cache else njit(kind, error_model="numpy")(function)


@lru_cache(maxsize=512)
def address_of(function: Any, kind: Any = FORCE) -> int:
    """Return the address of a compiled function of a kind, FORCE or RATES; 0 for None. It does not change."""
    if function is None:
        return 0
    if tuple(kind.args) not in function.overloads:
        function.compile(kind)
    return int(_get_wrapper_address(function, kind))


def _call(result: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        kind = ir.FunctionType(context.get_value_type(result), kinds)
        return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), arguments[1:])

    return generate


@intrinsic
def call_force(typing, address, t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Call the force at `address`."""
    return signature(_SCALAR, types.int64, *_ARGUMENTS), _call(_SCALAR)


@intrinsic
def call_rates(typing, address, t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Call the rates at `address`."""
    return signature(STATE_TUPLE, types.int64, *_ARGUMENTS), _call(STATE_TUPLE)
