"""`station export`: channels on one clock; nothing is overwritten unasked; bad wishes are refused in a sentence."""

import json

import numpy as np
import pytest

from daq.importing import ImportOptions, read_file
from mocks.generate import draw
from station.cli import run


@pytest.fixture(scope="module")
def late_displacement(tmp_path_factory):
    """A simulated release, its displacement 2.3 ms late by interpolation of the mocks' own; the session's folder."""
    folder = tmp_path_factory.mktemp("export")
    x = draw(None, 0.0, 5)
    time = np.arange(len(x.displacement)) / x.rate
    rows = zip(time, x.displacement, x.acceleration, strict=True)
    text = "\n".join(
        [
            "time [s],displacement [m],acceleration [m/s^2]",
            *(",".join(map(repr, map(float, r))) for r in rows),
        ]
    )
    (folder / "release.csv").write_text(text + "\n")
    return folder, x


def exported(capsys, *arguments):
    assert run(["export", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_the_lag_is_taken_out_and_stated(late_displacement, monkeypatch, capsys):
    folder, x = late_displacement
    monkeypatch.chdir(folder)
    moved = exported(capsys, "release.csv", "--file", "moved.csv")
    untouched = exported(capsys, "release.csv", "--file", "untouched.csv", "--as-recorded")
    assert moved["format"] == "csv"
    assert moved["channels"] == {"displacement": "m", "acceleration": "m/s^2"}
    lag = float(moved["facts"]["lag_s"])
    as_it_was = read_file(folder / "untouched.csv", ImportOptions())
    np.testing.assert_array_equal(as_it_was.channel("displacement"), x.displacement)
    assert "lag_s" not in untouched["facts"]
    aligned = read_file(folder / "moved.csv", ImportOptions())
    n = slice(300, 2000)
    speed = np.gradient(x.displacement, 1 / x.rate)
    expected = x.displacement + lag * speed
    assert abs(lag) > 1e-4, "the mocks' board has a lag"
    np.testing.assert_allclose(aligned.channel("displacement")[n], expected[n], atol=0.02 * np.ptp(expected))
    np.testing.assert_array_equal(aligned.channel("acceleration")[n], x.acceleration[n])


def test_a_file_that_is_there_stays(late_displacement, monkeypatch, capsys):
    folder, _ = late_displacement
    monkeypatch.chdir(folder)
    (folder / "mine.csv").write_text("mine")
    assert run(["export", "release.csv", "--file", "mine.csv"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert (folder / "mine.csv").read_text() == "mine"
    assert run(["export", "release.csv", "--file", "mine.csv", "--overwrite"]) == 0
    assert (folder / "mine.csv").read_text().startswith("# rate_hz")
    assert not list(folder.glob(".mine*")), "no temporary file is left"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--file", "x.doc"), "the ending tells no format"),
        (("--file", "nowhere/x.csv"), "the folder nowhere is not there"),
        (("--to", "xlsx"), "xlsx"),
    ],
)
def test_a_wish_that_cannot_be_met_is_refused_in_a_sentence(
    late_displacement, monkeypatch, capsys, arguments, says
):
    folder, _ = late_displacement
    monkeypatch.chdir(folder)
    assert run(["export", "release.csv", *arguments]) == 2
    assert says in capsys.readouterr().err
