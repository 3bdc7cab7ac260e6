"""The tutorial runs from its first cell to its last, and its page shows what it says today."""

import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
sys.path.insert(0, str(DOCS / "tools"))

from run_notebook import executed  # noqa: E402

pytestmark = pytest.mark.slow

FIGURES = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+| × 10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)?")


@pytest.fixture(scope="module")
def kept() -> dict[str, Any]:
    notebook: dict[str, Any] = json.loads((DOCS / "tutorial.ipynb").read_text(encoding="utf-8"))
    return notebook


@pytest.fixture(scope="module")
def today(kept: dict[str, Any]) -> dict[str, Any]:
    return executed(kept, DOCS)


def words(notebook: dict[str, Any]) -> list[list[str]]:
    """Return the words of each output; figures may differ in their last digit between computers."""
    shown = []
    for cell in notebook["cells"]:
        for output in cell.get("outputs", ()):
            text = "".join(output.get("text") or output["data"]["text/plain"])
            shown.append(FIGURES.sub("#", text).split())
    return shown


def test_what_the_page_shows_is_what_the_cells_give(kept: dict[str, Any], today: dict[str, Any]):
    assert words(today) == words(kept)


def test_the_hidden_effect_is_named_and_the_ladder_ends_at_the_floor(today: dict[str, Any]):
    shown = [" ".join(output) for output in words(today)]
    assert any(text.startswith("A force is missing: Stribeck friction") for text in shown)
    assert any(text.startswith("Ladder:") and text.endswith("yes") for text in shown)


def test_every_picture_is_drawn(today: dict[str, Any]):
    calls = [
        c for c in today["cells"] if c["cell_type"] == "code" and "".join(c["source"]).startswith("draw(")
    ]
    assert len(calls) >= 6
    for cell in calls:
        assert len(cell["outputs"][0]["data"]["image/png"]) > 5000


def test_a_cell_that_fails_is_no_page():
    broken = {"cells": [{"cell_type": "code", "source": ["1 / 0"]}]}
    with pytest.raises(ZeroDivisionError):
        executed(broken, DOCS)
