from pathlib import Path

import pytest

from identify.effects.library import LIBRARY
from identify.effects.user import parse_effect

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("effect", LIBRARY, ids=lambda effect: effect.name)
def test_the_page_tells_of_every_effect_as_the_library_has_it(effect):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{effect.name}` "))
    assert effect.title in row
    assert effect.equation.replace("|", "\\|") in row
    assert effect.symptom in row


def test_the_line_on_the_page_is_read():
    line = next(line for line in PAGE.splitlines() if line.startswith("station refine SESSION --add"))
    effect = parse_effect(line.split('"')[1])
    assert [p.name for p in effect.parameters] == ["q", "at", "width"]
    assert effect.parameters[2].low == 0.0005
