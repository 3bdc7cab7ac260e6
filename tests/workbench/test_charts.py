"""What is drawn from a stranger's session is data, never script or markup."""

import json
from dataclasses import replace

from station.workbench import charts, view_models
from station.workbench.theme import DARK, LIGHT

EVIL = "m'+alert(1)+\"<img src=x onerror=alert(1)>"
CUT = view_models.Section("u = 0", [0.0, 1.0], [0.1, None], [0.01, None])
PICTURE = view_models.Picture(
    time=[0.0, 0.1, 0.2],
    displacement=[1.0, 0.0, -1.0],
    velocity=[0.0, -1.0, 0.0],
    force=[0.1, None, -0.1],
    displacement_unit="mm",
    velocity_unit="m/s",
    force_unit="N",
    traces=(
        view_models.Trace(
            "displacement", "mm", "µm", [1.0, None, -1.0], [1.0, 0.0, -1.0], [3.0, None, -3.0], 2.0, 1e3
        ),
    ),
    plane=view_models.Plane([[-1.0, 1.0, -1.0, 1.0, 0.2, 0.1]], CUT, (CUT, CUT)),
    cycles=view_models.Cycles([0.1], [0.5], [0.1], [1.0], [0.2], "mJ"),
    errors={},
    summary="",
    cause="",
    places=(),
)


def scripts(value):
    if isinstance(value, dict):
        for key, item in value.items():
            yield from [item] if key.startswith(":") else scripts(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            yield from scripts(item)


def all_options(picture, colours):
    trace = picture.traces[0]
    return [
        charts.overlay(picture, trace, colours),
        charts.residual(picture, trace, colours),
        charts.plane(picture, colours),
        *charts.sections(picture, colours),
        *charts.cycles(picture, colours),
    ]


def test_a_unit_enters_a_script_as_a_string_and_tooltips_are_no_markup():
    evil = replace(PICTURE, force_unit=EVIL, displacement_unit=EVIL, velocity_unit=EVIL)
    found = [script for options in all_options(evil, LIGHT) for script in scripts(options)]
    assert found
    for script in found:
        assert "alert" not in script.replace(json.dumps(f" {EVIL}"), "")
    assert charts.plane(evil, LIGHT)["tooltip"]["renderMode"] == "richText"


def test_the_band_of_the_noise_is_two_standard_deviations_on_each_side_of_the_model():
    low, width = charts.overlay(PICTURE, PICTURE.traces[0], DARK)["series"][:2]
    assert [y for _, y in low["data"]] == [1.0 - 0.004, -0.004, -1.0 - 0.004]  # 2 std = 4 µm = 0.004 mm
    assert {y for _, y in width["data"]} == {0.008}
    left = charts.residual(PICTURE, PICTURE.traces[0], DARK)["series"][0]
    assert left["markArea"]["data"] == [[{"yAxis": -4.0}, {"yAxis": 4.0}]]


def test_lost_samples_are_holes_in_both_colour_schemes():
    for colours in (LIGHT, DARK):
        measured = charts.overlay(PICTURE, PICTURE.traces[0], colours)["series"][2]
        assert measured["data"] == [[0.0, 1.0], [0.1, None], [0.2, -1.0]]
