"""The drawing on the page of the architecture is that of the import contracts and of the folders."""

import re

import pytest
from contracts import ROOT, Layers, contracts, split_layer

PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
DRAWING = re.search(r"```text\n(┌.*?)```", PAGE, re.DOTALL).group(1)


def boxes(drawing: str) -> dict[str, tuple[int, list[tuple[str, ...]]]]:
    """The line on which each box begins, and the rows of names in it, by the package's name."""
    lines, found = drawing.splitlines(), {}
    for number, line in enumerate(lines):
        for header in re.finditer(r"┌ (\w+) ─*┐", line):
            rows = []
            for below in lines[number + 1 :]:
                inside = below[header.start() : header.end()]
                if inside.startswith("└"):
                    break
                names = re.split(r"\s{2,}", inside.strip("│ "))[0]
                rows.append(split_layer(names))
            found[header[1]] = (number, rows)
    return found


def is_a_room(package: str, name: str) -> bool:
    return (ROOT / package / name / "__init__.py").is_file()


def exists(package: str, name: str) -> bool:
    return is_a_room(package, name) or (ROOT / package / f"{name}.py").is_file()


def mistakes(drawing: str, layers: dict[str, Layers]) -> list[str]:
    """What the drawing has wrong: a package or room that is not drawn, a name that is nowhere, a row out of order."""
    drawn, wrong = boxes(drawing), []
    for package in (name for layer in layers[""] for name in layer):
        if package not in drawn:
            wrong.append(f"{package} is not drawn")
            continue
        place = {name: depth for depth, layer in enumerate(layers[package]) for name in layer}
        rows = drawn[package][1]
        names = [name for row in rows for name in row]
        wrong += [f"{package}.{name} is nowhere" for name in names if not exists(package, name)]
        wrong += [f"{package}.{name} is in no layer" for name in names if name not in place]
        missing = [name for name in place if is_a_room(package, name) and name not in names]
        wrong += [f"{package}.{name} is not drawn" for name in missing]
        depths = [{place[name] for name in row if name in place} for row in rows]
        wrong += [
            f"{package}: {row} is not one layer" for row, at in zip(rows, depths, strict=True) if len(at) > 1
        ]
        order = [depth for at in depths for depth in at]
        if order != sorted(set(order)):
            wrong.append(f"{package}: the rows are not in the order of the layers")
    heights = [{drawn[name][0] for name in layer if name in drawn} for layer in layers[""]]
    flat = [height for at in heights for height in at]
    if flat != sorted(set(flat)):
        wrong.append("the packages are not in the order of the layers")
    return wrong


def test_the_drawing_agrees_with_the_contracts_and_the_folders():
    assert mistakes(DRAWING, contracts()) == []


def test_every_room_of_identify_and_station_is_drawn_even_if_it_is_a_single_module():
    drawn = boxes(DRAWING)
    for package in ("identify", "station"):
        assert tuple(drawn[package][1]) == contracts()[package]


def test_every_room_of_identify_has_its_line_in_the_table():
    rooms = [name for layer in contracts()["identify"] for name in layer if is_a_room("identify", name)]
    rows = " ".join(line.split("|")[1] for line in PAGE.splitlines() if line.startswith("| `"))
    assert [room for room in rooms if f"`{room}`" not in rows] == []


def test_no_line_of_the_drawing_is_longer_than_its_boxes():
    assert {len(line) for line in DRAWING.splitlines() if line[0] in "┌│└"} <= {95, 83}


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (("comparison | diagnosis", "comparison            "), "identify.diagnosis is not drawn"),
        (("importing : exporting", "exporting            "), "daq.importing is not drawn"),
        (("signal | effects", "signal | effects | attic"), "identify.attic is nowhere"),
        (("preprocessing | model              ", "preprocessing | model | comparison "), "is not one layer"),
        (("│ commands ", "│ story    "), "station: the rows are not in the order of the layers"),
        (("┌ firmware_protocol ─", "┌ wire ──────────────"), "firmware_protocol is not drawn"),
        (("┌ mocks ─", "┌ daq ───"), "mocks is not drawn"),
    ],
)
def test_a_wrong_drawing_is_found_out(change, complaint):
    wrong = DRAWING.replace(*change, 1)
    assert wrong != DRAWING
    assert any(complaint in mistake for mistake in mistakes(wrong, contracts()))


def test_a_package_above_one_that_imports_it_is_found_out():
    layers = contracts()
    turned = layers | {"": tuple(reversed(layers[""]))}
    assert "the packages are not in the order of the layers" in mistakes(DRAWING, turned)
