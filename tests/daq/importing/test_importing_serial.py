"""What a serial monitor shows: times before an arrow, labels and units in each row; and a chip's counts."""

from pathlib import Path

import numpy as np
import pytest
from import_files import load, refusal, said, swing

from daq.recording import Array

GREETING = "Sonar ready\n\n"


def clock(t: float) -> str:
    """Return a time of day a quarter past two."""
    return f"14:15:{t:06.3f}"


def motion() -> tuple[Array, Array]:
    """Return the time (s) and a distance (cm) about 30 cm."""
    t, x, _, _ = swing(300)
    return t, 30.0 + 1e3 * x


@pytest.mark.parametrize("above", ["", GREETING])
@pytest.mark.parametrize(
    "row",
    [
        "{clock} -> Distance: {x:.2f} cm",
        "t={t:.2f}, distance={x:.2f} cm",
        "time: {t:.2f} s\tdistance: {x:.2f} cm",
    ],
)
def test_labels_and_units_in_each_row_are_understood(tmp_path: Path, row: str, above: str) -> None:
    t, x = motion()
    text = above + "".join(row.format(clock=clock(a), t=a, x=b) + "\n" for a, b in zip(t, x, strict=True))
    recording = load(tmp_path, text)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "m")]
    assert recording.rate == pytest.approx(100.0)
    np.testing.assert_allclose(recording.samples[0], x / 100.0, atol=6e-5)
    assert "in each row was read" in said(recording)


@pytest.mark.parametrize(
    "row",
    [
        "{clock} -> Abstand: {x:.2f} cm",
        "{clock} -> {x:.2f} cm",
        "t={t:.2f}; Weg={x:.2f} cm",
        "Zeit: {t:.2f} s\tWeg: {x:.2f} cm",
    ],
)
def test_a_decimal_comma_is_no_separator(tmp_path: Path, row: str) -> None:
    t, x = motion()
    rows = [row.format(clock=clock(a), t=a, x=b).replace(".", ",") for a, b in zip(t, x, strict=True)]
    columns = {} if "Weg" in row or "Abstand" in row else {"displacement": 2}
    recording = load(tmp_path, "\n".join(rows) + "\n", columns=columns)
    assert recording.rate == pytest.approx(100.0)
    np.testing.assert_allclose(recording.samples[0], x / 100.0, atol=6e-5)


@pytest.mark.parametrize(
    "row", ["{clock} -> {x:.2f}", "{clock} -> {x:.2f} {y:.3f}", "{clock} -> {x:.2f}; {y:.3f}"]
)
def test_a_bare_decimal_comma_is_read_where_somebody_says_so(tmp_path: Path, row: str) -> None:
    t, x = motion()
    rows = [row.format(clock="@", x=b, y=0.1 * b).replace(".", ",") for b in x]
    text = "".join(line.replace("@", clock(a)) + "\n" for a, line in zip(t, rows, strict=True))
    recording = load(tmp_path, text, decimal=",", columns={"displacement": 2}, units={"displacement": "cm"})
    np.testing.assert_allclose(recording.samples[0], x / 100.0, atol=6e-5)


def test_whole_numbers_between_commas_stay_apart(tmp_path: Path) -> None:
    t, x = motion()
    text = "".join(f"{clock(a)} -> {round(b)},{round(100 * b) % 1000}\n" for a, b in zip(t, x, strict=True))
    recording = load(tmp_path, text, columns={"displacement": 2}, units={"displacement": "cm"})
    np.testing.assert_allclose(recording.samples[0], np.rint(x) / 100.0, atol=1e-9)


def test_counts_between_commas_after_one_label_stay_apart(tmp_path: Path) -> None:
    t, x = motion()
    text = "".join(f"{clock(a)} -> raw: {round(1e3 * b)},7,8\n" for a, b in zip(t, x, strict=True))
    recording = load(tmp_path, text, columns={"displacement": 2}, units={"displacement": "mm"})
    np.testing.assert_allclose(recording.samples[0], np.rint(1e3 * x) / 1e3, atol=1e-9)


def test_units_in_the_cells_go_with_the_names_above(tmp_path: Path) -> None:
    t, x = motion()
    text = "time,distance\n" + "".join(f"{a:.2f} s,{b:.2f} cm\n" for a, b in zip(t, x, strict=True))
    recording = load(tmp_path, text)
    np.testing.assert_allclose(recording.samples[0], x / 100.0, atol=6e-5)


def test_a_plotter_s_labels_need_a_rate(tmp_path: Path) -> None:
    _, x = motion()
    text = "".join(f"angle:{0.01 * b:.4f},ref:0.00\n" for b in x)
    assert "--rate" in refusal(tmp_path, text)
    recording = load(tmp_path, text, rate=50.0)
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]


def test_bare_numbers_after_an_arrow_are_asked_for_and_read(tmp_path: Path) -> None:
    t, x = motion()
    text = "".join(f"{clock(a)} -> {b:.2f}\n" for a, b in zip(t, x, strict=True))
    assert "whether column 2 is a displacement" in refusal(tmp_path, text)
    recording = load(tmp_path, text, columns={"displacement": 2}, units={"displacement": "cm"})
    np.testing.assert_allclose(recording.samples[0], x / 100.0, atol=6e-5)


def test_a_row_that_was_cut_off_is_lost(tmp_path: Path) -> None:
    t, x = motion()
    rows = [f"{clock(a)} -> Distance: {b:.2f} cm" for a, b in zip(t, x, strict=True)]
    rows[100] = "14:15:01.000 -> Dista"
    recording = load(tmp_path, "\n".join(rows) + "\n")
    assert recording.samples.shape[1] == 300
    assert np.flatnonzero(~recording.valid).tolist() == [100]
