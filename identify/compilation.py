"""Functions compiled to machine code, kept on disk until anything that was compiled into them changes.

numba keeps compiled code while the file of the function is the same. It does not see that a function of another file,
which is compiled into this one, or a constant from there, has changed; so an update of the program leaves the
machine code of the old one in the files that it did not touch. Here the stamp of what is kept covers both.

numba also reads `.numba_config.yaml` in the working folder, when it is imported and whenever it compiles: it may name the
folder of the kept code, which is then run. Here it is imported without; a caller who imported it before has chosen.
"""

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from hashlib import sha256
from inspect import unwrap
from types import CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np

if "numba" not in sys.modules:
    _yaml = sys.modules.get("yaml")
    sys.modules["yaml"] = None  # type: ignore[assignment]  # numba reads no settings where there is no yaml
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that settings are there and cannot be read
            from numba.core import config
    finally:
        del sys.modules["yaml"]
        if _yaml is not None:
            sys.modules["yaml"] = _yaml
    config._config_fname = ""

from numba import njit, types
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys
from numba.core.typing import Signature


def compiled(signature: Any = None, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator as numba's `njit(signature, cache=True, **options)`, whose cache knows what a function calls.

    Where no folder can be written, the function is compiled anew in each process.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        dispatcher = njit(**options)(function)
        with suppress(RuntimeError):  # numba found no folder, neither beside the source nor the user's
            dispatcher._cache = _Cache(function, dispatcher)
        if signature is not None:
            dispatcher.compile(signature)
            dispatcher.disable_compile()
        return dispatcher

    return decorate


class _Cache(FunctionCache):  # type: ignore[misc]
    """numba's cache of one function, with the fingerprint of all that is compiled into it added to the stamp."""

    def __init__(self, function: Callable[..., Any], dispatcher: Any) -> None:
        super().__init__(function)
        self._dispatcher, self._is_stamped = dispatcher, False

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """As numba's, without the tenth of a second in which numba readies itself to compile: it does so when it must.

        The stamp is taken here: when a function is compiled, all that it calls has been defined.
        """
        if not self._is_stamped:
            stamp = (self._impl.locator.get_source_stamp(), fingerprint(self._dispatcher))
            self._cache_file = IndexDataCacheFile(self.cache_path, self._impl.filename_base, stamp)
            self._is_stamped = True
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


def fingerprint(function: Any) -> str:
    """Return a digest of a compiled function: its code and options, and those of all that it calls in its package."""
    package = _package_of(unwrap(function))
    return sha256("\n".join(_parts(function, package, set())).encode()).hexdigest()


def _package_of(function: Any) -> str:
    return str(function.__module__).partition(".")[0]


def _parts(value: Any, package: str, seen: set[Any]) -> Iterator[str]:
    plain = unwrap(value) if callable(value) else value
    if isinstance(plain, FunctionType):
        yield f"{plain.__module__}.{plain.__qualname__}"
        if _package_of(plain) == package and plain not in seen:
            seen.add(plain)
            yield repr(sorted(getattr(value, "targetoptions", {}).items()))
            yield from _parts_of_function(plain, package, seen)
    elif isinstance(plain, tuple):
        for element in plain:
            yield from _parts(element, package, seen)
    elif isinstance(plain, np.ndarray):
        yield f"{plain.dtype} {plain.shape} {plain.tobytes().hex()}"
    elif isinstance(
        plain, bool | int | float | complex | str | bytes | np.generic | types.Type | Signature | None
    ):
        yield repr(plain)
    else:
        yield type(
            plain
        ).__qualname__  # not a constant of compiled code; its text might differ from run to run


def _parts_of_function(function: FunctionType, package: str, seen: set[Any]) -> Iterator[str]:
    names: list[str] = []
    for code in _codes(function.__code__):
        names += code.co_names
        yield code.co_code.hex()
        for constant in code.co_consts:
            yield from _parts(
                tuple(sorted(constant, key=repr)) if isinstance(constant, frozenset) else constant,
                package,
                seen,
            )
    yield repr(names)
    yield from _parts(function.__defaults__ or (), package, seen)
    for cell in function.__closure__ or ():
        yield from _parts(cell.cell_contents, package, seen)
    for name in names:
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType) and value.__name__.partition(".")[0] == package:
            for attribute in names:
                yield from _parts(getattr(value, attribute, None), package, seen)
        else:
            yield from _parts(value, package, seen)


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)
