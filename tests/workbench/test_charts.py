"""What is drawn from a stranger's session is data, never script or markup."""

from dataclasses import replace

from station.workbench import charts, curve_charts, view_models
from station.workbench.theme import DARK, LIGHT

EVIL = "m'+alert(1)+\"<img src=x onerror=alert(1)>"
CUT = view_models.Section("u = 0", [0.0, 1.0], [0.1, None], [0.01, None])
PICTURE = view_models.Picture(
    time=[0.0, 0.1, 0.2],
    displacement_unit="mm",
    velocity_unit="m/s",
    force_unit="N",
    plane=view_models.Plane(CUT, (CUT, CUT)),
    cycles=view_models.Cycles([0.1], [0.5], [0.1], [1.0], [0.2], "mJ"),
    errors={},
    words="",
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
    return [*charts.sections(picture, colours), *charts.cycles(picture, colours)]


def test_a_unit_enters_no_script():
    evil = replace(PICTURE, force_unit=EVIL, displacement_unit=EVIL, velocity_unit=EVIL)
    found = [script for options in all_options(evil, LIGHT) for script in scripts(options)]
    assert found
    assert not any("alert" in script for script in found)


def test_what_is_unknown_is_left_out_of_a_cut_in_both_colour_schemes():
    for colours in (LIGHT, DARK):
        _, points = charts.sections(PICTURE, colours)[0]["series"]
        assert points["data"] == [[0.0, 0.1]]


NONE = [0.0, 0.0]
CURVES = view_models.DecayCurves(
    "mm",
    (
        view_models.AmplitudeLine(
            "one", "measured", [2.0, 1.0], [4.0, 3.9], [0.01, 0.01], [1.0, 2.0], [0.1, 0.1]
        ),
        view_models.AmplitudeLine(
            "two", "measured", [2.0, 1.0], [4.1, 4.0], [0.02, 0.02], [1.5, 2.5], [0.2, 0.2]
        ),
        view_models.AmplitudeLine("usual model", "usual", [2.0, 1.0], [3.95, 3.95], NONE, [1.2, 1.2], NONE),
        view_models.AmplitudeLine(f"with {EVIL}", "named", [2.0, 1.0], [4.0, 3.9], NONE, [1.0, 2.0], NONE),
        view_models.AmplitudeLine("or another", "rival", [2.0, 1.0], [4.0, 3.91], NONE, [1.1, 2.0], NONE),
    ),
    (3.8, 4.2),
    (0.5, 3.0),
)


def test_every_release_and_model_is_in_both_curve_charts_and_named_once():
    frequency, damping = curve_charts.decay_curves(CURVES, LIGHT)
    for chart, quantity in ((frequency, "frequency"), (damping, "damping")):
        named = [one for one in chart["series"] if "name" in one]
        assert [one["name"] for one in named] == [line.name for line in CURVES.lines]
        for one, line in zip(named, CURVES.lines, strict=True):
            assert one["data"] == [
                list(pair) for pair in zip(line.amplitude, getattr(line, quantity), strict=True)
            ]
        widths = [one["lineStyle"]["width"] for one in named]
        assert widths[0] == widths[1] == 0
        assert widths[2] < widths[4] < widths[3]  # usual, rival, named
    assert frequency["legend"]["data"] == ["usual model", f"with {EVIL}", "or another"]
    assert damping["legend"]["data"] == ["one", "two"]
    assert damping["xAxis"]["name"] == "amplitude [mm]"


def test_the_bars_of_a_curve_are_two_standard_errors_on_each_side():
    _, damping = curve_charts.decay_curves(CURVES, DARK)
    first, _, second, *_ = damping["series"]
    assert first["data"] == [[2.0, 0.8, 1.2], [1.0, 1.8, 2.2]]
    assert second["data"] == [[2.0, 1.1, 1.9], [1.0, 2.1, 2.9]]


def test_the_name_of_an_effect_enters_no_script():
    found = [s for chart in curve_charts.decay_curves(CURVES, LIGHT) for s in scripts(chart)]
    assert found
    assert not any("alert" in script for script in found)
