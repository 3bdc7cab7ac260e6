"""Nobody outside identify/effects knows an effect by its name, so that a new one needs a file and a line."""

import ast
import importlib
import re
from pathlib import Path

import pytest

from identify.effects.effect import Effect
from identify.effects.families import FAMILIES
from identify.effects.library import LIBRARY

ROOT = Path(__file__).resolve().parents[2]
INSIDE = ROOT / "identify" / "effects"
MODULES = [
    file
    for package in ("identify", "station", "daq")
    for file in sorted((ROOT / package).rglob("*.py"))
    if INSIDE not in file.parents
]
KNOWN = (*LIBRARY, *(family.effect for family in FAMILIES))
NAMED = re.compile(rf"({'|'.join(effect.name for effect in KNOWN)})(\..*)?")


def literals_that_name_an_effect(source: str) -> list[str]:
    """Return the strings of a module that are an effect's name, or a parameter's such as "linear_stiffness.k"."""
    strings = [n.value for n in ast.walk(ast.parse(source)) if isinstance(n, ast.Constant)]
    return [text for text in strings if isinstance(text, str) and NAMED.fullmatch(text)]


def imports_of_an_effect(source: str) -> list[str]:
    """Return the effects that a module imports, such as CUBIC_STIFFNESS."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("identify.effects"):
            module = importlib.import_module(str(node.module))
            found += [
                name.name for name in node.names if isinstance(getattr(module, name.name, None), Effect)
            ]
    return found


def test_no_module_outside_the_effects_knows_one_of_them():
    found = {}
    for file in MODULES:
        source = file.read_text(encoding="utf-8")
        named = [*literals_that_name_an_effect(source), *imports_of_an_effect(source)]
        if named:
            found[str(file.relative_to(ROOT))] = named
    assert found == {}


@pytest.mark.parametrize(
    "source",
    ['k = values["linear_stiffness.k"]', 'if effect.name == "freeplay": pass', 'x = {"dropouts": 1}'],
)
def test_a_name_in_a_string_is_seen(source):
    assert len(literals_that_name_an_effect(source)) == 1


def test_a_word_within_a_sentence_is_no_name():
    assert literals_that_name_an_effect('"""Play, as in freeplay, or clipping."""') == []


def test_an_import_is_seen_and_the_library_is_not_one():
    assert imports_of_an_effect("def f():\n    from identify.effects.sensors import CLIPPING") == ["CLIPPING"]
    assert imports_of_an_effect("from identify.effects.library import BASE, LIBRARY, find_effect") == []
