"""LabVIEW's measurement files: two headers, decimal commas, time written or not, several segments."""

from pathlib import Path

import numpy as np
import pytest
from import_files import RATE, load, refusal, swing, write

from daq.importing.reading import look_at
from daq.importing.recipe import Recipe

FILE = "LabVIEW Measurement\t\nWriter_Version\t2\nReader_Version\t2\nSeparator\tTab\nDecimal_Separator\t{point}\n{more}"
CHANNELS = (
    "Channels\t2\t\t\nSamples\t300\t300\t\nDate\t2023/05/11\t2023/05/11\t\nTime\t14:02:33,12\t14:02:33,12\t\n"
)
CLOSED = "***End_of_Header***\t\n"


def two_channels(x_columns: str = "One", point: str = ",") -> str:
    """Return a file of an acceleration in g and a voltage, as LabVIEW writes it."""
    t, u, _, a = swing(300)
    more = f"Multi_Headings\tYes\nX_Columns\t{x_columns}\nTime_Pref\tRelative\nTime\t14:02:33,12\n"
    head = FILE.format(point=point, more=more) + CLOSED + "\t\n" + CHANNELS
    head += f"Y_Unit_Label\tg\tVolts\t\nX_Dimension\tTime\tTime\t\nX0\t0{point}0\t0{point}0\t\n"
    head += f"Delta_X\t{1 / RATE:.8f}\t{1 / RATE:.8f}\t\n".replace(".", point)
    rows = "".join(
        f"{'' if x_columns == 'No' else f'{x:.6f}'}\t{y / 9.80665:.6f}\t{z:.6f}\t\n"
        for x, y, z in zip(t, a, u, strict=True)
    )
    return head + CLOSED + "X_Value\tAcceleration\tVoltage\tComment\n" + rows.replace(".", point)


@pytest.mark.parametrize("x_columns", ["One", "No"])
@pytest.mark.parametrize("point", [",", "."])
def test_names_units_and_time_come_from_the_headers(tmp_path: Path, x_columns: str, point: str) -> None:
    recording = load(tmp_path, two_channels(x_columns, point), "a.lvm")
    assert recording.rate == pytest.approx(RATE, rel=1e-5)
    assert [(c.name, c.quantity, c.unit) for c in recording.channels] == [
        ("Acceleration", "acceleration", "m/s^2")
    ]
    assert recording.samples[0] == pytest.approx(swing(300)[3], abs=2e-5)


def test_of_several_segments_a_recipe_reads_each(tmp_path: Path) -> None:
    text = two_channels(point=".")
    second = text[text.index("Channels\t2") :].replace("\t0.", "\t7.")
    lines = (text + "\n" + second).split("\n")
    words = [i for i, line in enumerate(lines, start=1) if i > 100 and line and not line[0].isdigit()]
    assert "is not a number" in refusal(tmp_path, "\n".join(lines), "a.lvm")
    fields = (
        {"column": 1, "role": "time"},
        {"column": 2, "role": "acceleration", "unit": "g"},
    )
    recipe = Recipe.model_validate({"restarts": True, "dialect": {"commentRows": words}, "fields": fields})
    first, again = look_at(write(tmp_path, "\n".join(lines), "a.lvm"), recipe=recipe).read().recordings
    assert first.samples.shape == again.samples.shape == (1, 300)


def test_a_file_without_time_and_step_is_refused_in_words(tmp_path: Path) -> None:
    text = two_channels("No", ".").replace("Delta_X", "Delta_Y")
    assert "--rate" in refusal(tmp_path, text, "a.lvm")


@pytest.mark.parametrize(
    "text", ["LabVIEW Measurement\n", "LabVIEW Measurement\n***End_of_Header***\n1\t2\n"]
)
def test_what_is_cut_off_in_its_headers_is_refused(tmp_path: Path, text: str) -> None:
    assert refusal(tmp_path, text, "a.lvm")


def test_numbers_of_a_channel_that_is_not_there_are_invalid(tmp_path: Path) -> None:
    lines = two_channels(point=".").split("\n")
    first = next(i for i, line in enumerate(lines) if line.startswith("X_Value")) + 1
    time, _, voltage, _ = lines[first + 5].split("\t")
    lines[first + 5] = f"{time}\t\t{voltage}\t"
    recording = load(tmp_path, "\n".join(lines), "a.lvm")
    assert not recording.valid[5]
    assert np.count_nonzero(~recording.valid) == 1
