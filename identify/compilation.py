"""Functions compiled to machine code, kept on disk until anything that was compiled into them changes.

numba keeps compiled code while the file of the function is the same. It does not see that a function of another file,
which is compiled into this one, or a constant from there, has changed; so an update of the program leaves the
machine code of the old one in the files that it did not touch. Here the stamp of what is kept covers the sources of all
modules that the function's own is built on.

numba also reads `.numba_config.yaml` in the working folder, when it is imported and whenever it compiles: it may name the
folder of the kept code, which is then run. Here it is imported without; a caller who imported it before has chosen.
"""

import re
import sys
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from hashlib import sha256
from inspect import getsource
from types import ModuleType
from typing import Any

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
            dispatcher._cache = _Cache(function)
        if signature is not None:
            dispatcher.compile(signature)
            dispatcher.disable_compile()
        return dispatcher

    return decorate


class _Cache(FunctionCache):  # type: ignore[misc]
    """numba's cache of one function, with the fingerprint of its module added to the stamp."""

    _is_stamped = False

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """As numba's, without the tenth of a second in which numba readies itself to compile: it does so when it must.

        The stamp is taken here: when a function is loaded, all modules that it is built on have been imported.
        """
        if not self._is_stamped:
            stamp = (
                self._impl.locator.get_source_stamp(),
                fingerprint(sys.modules[self._py_func.__module__]),
            )
            self._cache_file = IndexDataCacheFile(self.cache_path, self._impl.filename_base, stamp)
            self._is_stamped = True
        rtsys.initialize(target_context)
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)


@cache
def fingerprint(module: ModuleType) -> str:
    """Return a digest of the source of a module and of those of all modules of its package that it is built on."""
    package = module.__name__.partition(".")[0]
    imports = re.compile(rf"^ *(?:from|import) +({package}[\w.]*)(?: +import +(.*))?", re.MULTILINE)
    sources: dict[str, str] = {}
    names = [module.__name__]
    while names:
        name = names.pop()
        if name not in sources and name in sys.modules:
            sources[name] = getsource(sys.modules[name])
            for home, members in imports.findall(sources[name]):
                names += [home, *(f"{home}.{member}" for member in re.findall(r"\w+", members))]
    return sha256(repr(sorted(sources.items())).encode()).hexdigest()
