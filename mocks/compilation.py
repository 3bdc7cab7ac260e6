"""Functions compiled to machine code, kept on disk until anything that was compiled into them changes.

numba keeps compiled code while the file of the function is the same. It does not see that a function of another file,
which is compiled into this one, or a constant from there, has changed; so an update of the program leaves the
machine code of the old one in the files that it did not touch. Here the stamp of what is kept covers both.

numba also reads `.numba_config.yaml` in the working folder, when it is imported and whenever it compiles: it may name the
folder of the kept code, which is then run. Here it is imported without; a caller who imported it before has chosen.
"""

import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from hashlib import sha256
from inspect import unwrap
from types import ModuleType
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

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.runtime import rtsys


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
    """Return a digest of all that may be compiled into a function: its module and those of its package that it takes from.

    Of each the source, and the values of its constants, wherever they were imported from.
    """
    found, modules = dict[str, str](), [sys.modules[unwrap(function).__module__]]
    package = modules[0].__name__.partition(".")[0]
    while modules:
        module = modules.pop()
        if module.__name__ not in found and module.__name__.partition(".")[0] == package:
            found[module.__name__], others = _of_module(module)
            modules += others
    return sha256(repr(sorted(found.items())).encode()).hexdigest()


@lru_cache
def _of_module(module: ModuleType) -> tuple[str, list[ModuleType]]:
    """Return a digest of one module, and the modules that its names come from."""
    values = {name: value for name, value in vars(module).items() if not name.startswith("__")}
    constants = sorted((name, _written(value)) for name, value in values.items())
    source = vars(module)["__loader__"].get_source(module.__name__)
    # what a package holds depends on what has been imported: of modules only those without a path are followed
    modules = [one for one in values.values() if isinstance(one, ModuleType) and not hasattr(one, "__path__")]
    places = [getattr(one, "__module__", None) for one in values.values()]
    others = [*modules, *(sys.modules[place] for place in places if place in sys.modules)]
    return sha256(f"{source}{constants}".encode()).hexdigest(), others


def _written(value: Any) -> str:
    """Return a constant of compiled code as text; "" for all else, whose text might differ from run to run."""
    if isinstance(value, tuple):
        return repr([_written(one) for one in value])
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape} {value.tobytes().hex()}"
    return repr(value) if isinstance(value, bool | int | float | complex | str | np.generic) else ""
