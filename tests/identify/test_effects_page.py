from pathlib import Path

import pytest

from identify.effects.families import FAMILIES
from identify.effects.user import parse_effect

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "effects.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.effect.name)
def test_the_page_tells_of_every_family_and_its_members(family):
    row = next(line for line in PAGE.splitlines() if line.startswith(f"| `{family.effect.name}` "))
    assert family.effect.title in row
    assert family.effect.equation.replace("|", "\\|") in row
    assert ", ".join(f"{name} {exponent:g}" for name, exponent in family.members.items()) in row


def test_the_line_on_the_page_is_read():
    line = next(line for line in PAGE.splitlines() if line.startswith("station refine SESSION --add"))
    effect = parse_effect(line.split('"')[1])
    assert [p.name for p in effect.parameters] == ["q", "at", "width"]
    assert effect.parameters[2].low == 0.0005
