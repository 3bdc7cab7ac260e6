"""Machine code that is kept on disk is made anew when anything that was compiled into it has changed."""

import importlib
import itertools
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest
from numba.core.caching import CacheImpl

ROOT = Path(__file__).resolve().parents[2]
COPIES = ("identify", "mocks")
NUMBERS = itertools.count()

INNER = """
from {copy}.compilation import compiled
{constant}
@compiled(error_model="{error_model}")
def inner(x):
    return {formula}
"""
OUTER = """
from {copy}.compilation import compiled
from {package}.inner import FACTOR, inner

@compiled(error_model="numpy")
def outer(x):
    return _helper(x) * FACTOR

@compiled(error_model="numpy")
def _helper(x):
    return inner(x)
"""


class Package:
    """A package of two files: `outer` calls, by a helper that is defined after it, a function of the file `inner`."""

    def __init__(self, folder: Path, copy: str):
        self.name, self.folder, self.copy = f"two_files_{next(NUMBERS)}", folder, copy
        (folder / self.name).mkdir()
        (folder / self.name / "__init__.py").touch()
        outer = OUTER.format(package=self.name, copy=copy)
        (folder / self.name / "outer.py").write_text(outer, encoding="utf-8")

    def loaded(self, formula="x + 1.0", factor=1.0, error_model="numpy") -> ModuleType:
        """Write the file `inner` and import the package as a new process would."""
        inner = INNER.format(
            copy=self.copy, formula=formula, constant=f"FACTOR = {factor}", error_model=error_model
        )
        (self.folder / self.name / "inner.py").write_text(inner, encoding="utf-8")
        for module in [name for name in sys.modules if name.startswith(self.name)]:
            del sys.modules[module]
        importlib.invalidate_caches()
        return importlib.import_module(f"{self.name}.outer")


@pytest.fixture(params=COPIES)
def package(request, tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    return Package(tmp_path, request.param)


def hits(module) -> int:
    return sum(module.outer.stats.cache_hits.values())


def test_what_has_changed_in_another_file_is_compiled_anew_and_what_has_not_is_read_from_the_disk(package):
    first = package.loaded()
    assert (first.outer(2.0), hits(first)) == (3.0, 0)
    same = package.loaded()
    assert (same.outer(2.0), hits(same)) == (3.0, 1)
    other_function = package.loaded(formula="x + 5.0")
    assert (other_function.outer(2.0), hits(other_function)) == (7.0, 0)
    other_constant = package.loaded(formula="x + 5.0", factor=2.0)
    assert (other_constant.outer(2.0), hits(other_constant)) == (14.0, 0)


def test_the_options_of_a_called_function_count_too(package):
    assert package.loaded(formula="1.0 / x").outer(0.0) == float("inf")
    with pytest.raises(ZeroDivisionError):
        package.loaded(formula="1.0 / x", error_model="python").outer(0.0)


def test_where_nothing_can_be_kept_a_function_is_compiled_all_the_same(package, monkeypatch):
    monkeypatch.setattr(CacheImpl, "_locator_classes", [])
    assert package.loaded().outer(2.0) == 3.0
    assert list(package.folder.rglob("*.nbi")) == []


def test_every_function_that_is_kept_is_kept_in_this_way():
    sources = [path for copy in COPIES for path in (ROOT / copy).rglob("*.py")]
    assert len(sources) > 50
    found = [
        path for path in sources if re.search(r"^[^#\"`]*cache=True", path.read_text(encoding="utf-8"), re.M)
    ]
    assert found == []


def test_the_double_which_shares_nothing_with_the_program_has_the_same_module_a_second_time():
    texts = {(ROOT / copy / "compilation.py").read_text(encoding="utf-8") for copy in COPIES}
    assert len(texts) == 1
