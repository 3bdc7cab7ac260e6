"""Text tables as people have them."""

import codecs
from pathlib import Path

import numpy as np
import pytest
from import_files import load, refusal, said, swing, table

from daq.importing import ImportOptions, ImportProblem, read_file

T, U, V, A = swing()
EXACT = {"rtol": 1e-8, "atol": 0}  # the files hold nine significant digits


def test_named_columns_with_units_need_no_options(tmp_path: Path) -> None:
    recording = load(tmp_path, table("time_s,displacement_m,acceleration_m_s2", T, U, A))
    assert [(c.quantity, c.unit) for c in recording.channels] == [
        ("displacement", "m"),
        ("acceleration", "m/s^2"),
    ]
    np.testing.assert_allclose(recording.samples, [U, A], **EXACT)
    assert recording.valid.all()
    assert recording.rate == pytest.approx(100.0, rel=1e-9)
    assert "column 2 'displacement_m' read as displacement in m" in said(recording)


@pytest.mark.parametrize(
    ("delimiter", "comma"),
    [
        (",", False),
        *((delimiter, comma) for delimiter in (";", "\t", " ", "|", "   ") for comma in (False, True)),
    ],
)
def test_every_delimiter_goes_with_every_decimal_sign(tmp_path: Path, delimiter: str, comma: bool) -> None:
    header = delimiter.join(("Zeit[s]", "Weg[mm]", "Beschleunigung[g]"))
    text = table(header, T, U * 1e3, A / 9.80665, delimiter=delimiter, comma=comma)
    recording = load(tmp_path, text)
    np.testing.assert_allclose(recording.samples, [U, A], rtol=1e-7)


def test_decimal_commas_with_three_places_are_not_thousands(tmp_path: Path) -> None:
    recording = load(tmp_path, table("t/s;x/m", T, U, delimiter=";", form="%.3f", comma=True))
    np.testing.assert_allclose(recording.samples[0], np.round(U, 3), atol=1e-12)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_every_encoding_and_line_end_is_read(tmp_path: Path, encoding: str, newline: str) -> None:
    text = table("Zeit (s);Größe & Weg (µm)", T, U * 1e6, delimiter=";", comma=True)
    recording = load(tmp_path, text.replace("\n", newline).encode(encoding))
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-7)
    assert recording.channels[0].name == "Größe & Weg (µm)"


def test_an_encoding_that_was_guessed_is_named_and_another_is_suggested(tmp_path: Path) -> None:
    text = table("Czas (s);Położenie wózka (m)", T, U, delimiter=";", comma=True).encode("cp1250")
    guessed = " ".join(load(tmp_path, text).notes)
    assert "read as cp1252 (Western Europe); where letters are wrong" in guessed
    assert load(tmp_path, text, encoding="cp1250").channels[0].name == "Położenie wózka (m)"


def test_quoted_cells_may_hold_decimal_commas(tmp_path: Path) -> None:
    rows = [f'"{t:.9g}","{u:.9g}"'.replace(".", ",") for t, u in zip(T, U, strict=True)]
    recording = load(tmp_path, '"time (s)","position (m)"\n' + "\n".join(rows))
    np.testing.assert_allclose(recording.samples[0], U, **EXACT)


def test_a_comma_that_is_delimiter_and_decimal_sign_is_asked_about(tmp_path: Path) -> None:
    text = "time_s,position_mm\n" + "\n".join(f"0,{i:02d},1,{i:02d}" for i in range(50))
    assert "nothing says which column" in refusal(tmp_path, text)


def test_lines_above_the_header_and_remarks_and_unit_rows_are_understood(tmp_path: Path) -> None:
    text = "Logger 7, exported\n# operator: me\n\ntime,accel\n(s),(m/s^2)\n\n" + table("", T, A) + "# end\n"
    recording = load(tmp_path, text)
    assert [c.quantity for c in recording.channels] == ["acceleration"]
    np.testing.assert_allclose(recording.samples[0], A, **EXACT)


def test_a_header_may_be_a_remark(tmp_path: Path) -> None:
    recording = load(tmp_path, table("# t (s)  x (mm)", T, U * 1e3, delimiter="  "))
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-7)


def test_names_with_blanks_between_tabs_stay_whole(tmp_path: Path) -> None:
    recording = load(tmp_path, table("Time (s)\tPosition of the mass (m)", T, U, delimiter="\t"))
    assert recording.channels[0].name == "Position of the mass (m)"


def test_trailing_separators_and_empty_columns_are_no_channels(tmp_path: Path) -> None:
    text = "time_s;displacement_m;\n" + "".join(f"{t};{u};\n" for t, u in zip(T, U, strict=True))
    recording = load(tmp_path, text)
    assert recording.samples.shape == (1, 200)
    assert recording.valid.all()


def test_only_one_channel_is_enough(tmp_path: Path) -> None:
    for header, quantity, values in (
        ("x_m", "displacement", U),
        ("v_m_s", "velocity", V),
        ("a_g", "acceleration", A),
    ):
        recording = load(tmp_path, table(f"t_s,{header}", T, values))
        assert [c.quantity for c in recording.channels] == [quantity]


def test_empty_cells_are_invalid_and_never_filled(tmp_path: Path) -> None:
    lines = table("time_s,displacement_m,acceleration_m_s2", T, U, A).splitlines()
    cells = lines[21].split(",")
    lines[21] = f"{cells[0]},,{cells[2]}"
    lines[22] = lines[22].rsplit(",", 1)[0] + ",NaN"
    lines[50] = lines[50].rsplit(",", 1)[0] + ",inf"
    recording = load(tmp_path, "\n".join(lines))
    assert np.flatnonzero(~recording.valid).tolist() == [20, 21, 49]
    assert np.isnan(recording.samples[0, 20])
    assert [(g.first, g.count) for g in recording.gaps] == [(20, 2), (49, 1)]
    assert "line 22" in said(recording)


def test_a_cell_of_text_is_reported_by_line_and_column(tmp_path: Path) -> None:
    lines = table("time_s,displacement_m", T, U).splitlines()
    lines[41] = lines[41].split(",")[0] + ",overlaod"
    message = refusal(tmp_path, "\n".join(lines))
    assert "line 42, column 2" in message
    assert "'overlaod'" in message


def test_text_in_a_column_that_nobody_needs_does_no_harm(tmp_path: Path) -> None:
    rows = [f"{t},{u},ok" for t, u in zip(T, U, strict=True)]
    rows[7] = rows[7].replace("ok", "bumped, twice".replace(",", ""))
    recording = load(tmp_path, "time_s,displacement_m,comment\n" + "\n".join(rows))
    assert recording.valid.all()


def test_a_row_with_too_many_cells_is_reported_by_line(tmp_path: Path) -> None:
    lines = table("time_s,displacement_m", T, U).splitlines()
    lines[10] += ",5"
    assert "line 11: this row has 3 cells where most have 2; repair" in refusal(tmp_path, "\n".join(lines))
    lines[11] += ",5"
    assert "where most have 2, and 1 more are like it; repair" in refusal(tmp_path, "\n".join(lines))


def test_a_file_cut_off_in_its_last_row_is_read_to_there(tmp_path: Path) -> None:
    text = table("time_s,displacement_m,acceleration_m_s2", T, U, A)
    recording = load(tmp_path, text[: text.rindex(",")])
    assert recording.samples.shape == (2, 199)  # the last number may be cut short, too
    assert "cut short" in said(recording)


def test_several_candidates_are_named_and_none_is_taken(tmp_path: Path) -> None:
    message = refusal(tmp_path, table("time,x,y,phi", T, U, V, A))
    assert all(name in message for name in ("'x'", "'y'", "'phi'", "--column displacement="))


def test_options_choose_by_name_or_number_and_give_the_unit(tmp_path: Path) -> None:
    text = table("time,x,y,phi", T, U, V, np.degrees(A))
    for wanted in ("phi", 4, "4", " PHI "):
        recording = load(tmp_path, text, columns={"displacement": wanted}, units={"displacement": "deg"})
        assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "rad")]
        np.testing.assert_allclose(recording.samples[0], A, rtol=1e-7)


def test_one_asked_for_channel_brings_the_others_that_are_clear(tmp_path: Path) -> None:
    text = table("time_s,pos1_mm,pos2_mm,acc_g", T, U * 1e3, -U * 1e3, A / 9.80665)
    recording = load(tmp_path, text, columns={"displacement": "pos2_mm"})
    np.testing.assert_allclose(recording.samples, [-U, A], rtol=1e-7)
    alone = load(tmp_path, text, columns={"displacement": "pos1_mm", "acceleration": "none"})
    assert [c.quantity for c in alone.channels] == ["displacement"]


def test_without_any_header_numbers_name_the_columns(tmp_path: Path) -> None:
    text = table("", T, U * 1e3, A)
    assert "--column displacement=" in refusal(tmp_path, text)
    recording = load(
        tmp_path, text, columns={"displacement": 2, "acceleration": 3}, units={"displacement": "mm"}
    )
    np.testing.assert_allclose(recording.samples, [U, A], rtol=1e-7)
    assert "rise evenly" in said(recording)


def test_without_a_time_column_the_rate_comes_from_the_option_or_a_line_above(tmp_path: Path) -> None:
    text = table("displacement_m", U)
    assert "--rate" in refusal(tmp_path, text)
    assert load(tmp_path, text, rate=250.0).rate == 250.0
    named = load(tmp_path, "Sampling rate: 250 Hz\n" + text)
    assert named.rate == 250.0
    assert "line 1" in said(named)


def test_a_rate_beside_a_time_column_takes_its_place_and_says_so(tmp_path: Path) -> None:
    recording = load(tmp_path, table("time_s,displacement_m", T, U), rate=50.0)
    assert recording.rate == 50.0
    assert "not used: column 1 'time_s'" in said(recording)


def test_a_volt_stays_a_volt_and_a_scale_makes_it_a_length(tmp_path: Path) -> None:
    text = table("t_s,sensor (V)", T, U)
    volts = load(tmp_path, text, columns={"displacement": 2})
    assert volts.channels[0].unit == "V"
    metres = load(tmp_path, text, columns={"displacement": 2}, units={"displacement": "0.0025 m"})
    np.testing.assert_allclose(metres.samples[0], 0.0025 * U, **EXACT)


def test_an_angle_beside_a_length_is_refused(tmp_path: Path) -> None:
    message = refusal(tmp_path, table("t_s,angle_deg,acc_g", T, U, A))
    assert "--column acceleration=none" in message


def test_row_names_without_a_header_do_not_shift_the_columns(tmp_path: Path) -> None:
    recording = load(tmp_path, table("time_s,displacement_m", np.arange(1.0, 201.0), T, U))
    np.testing.assert_allclose(recording.samples[0], U, **EXACT)


def test_skipped_rows_do_not_shift_the_line_numbers(tmp_path: Path) -> None:
    lines = ["1,2", "3,4", "5,6", *table("time_s,displacement_m", T, U).splitlines()]
    assert load(tmp_path, "\n".join(lines), skip_rows=3).samples.shape == (1, 200)
    lines[20] = "x,y"
    assert "line 21, column 2" in refusal(tmp_path, "\n".join(lines), skip_rows=3)


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"", "empty"),
        (b"\n\n  \n", "empty"),
        (b"\0" * 100, "empty"),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20, "not text"),
        (b"hello world, this is a letter\nand no table\n", "no rows of numbers"),
        (b"time_s,displacement_m\n0,1\n0.1,2\n0.2,3\n", "samples"),
        (codecs.BOM_UTF16_LE + b"\x00\xd8\x00\xd8\x01", "utf-16"),
    ],
)
def test_what_is_no_table_gets_a_sentence(tmp_path: Path, content: bytes, word: str) -> None:
    assert word in refusal(tmp_path, content)


def test_a_missing_file_a_folder_and_a_device_get_a_sentence(tmp_path: Path) -> None:
    for path, word in (
        (tmp_path / "no.csv", "not exist"),
        (tmp_path, "folder"),
        (Path("/dev/zero"), "plain file"),
    ):
        with pytest.raises(ImportProblem, match=word):
            read_file(path, ImportOptions())


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"columns": {"displacement": "nope"}}, "no column 'nope'"),
        ({"columns": {"displacement": 9}}, "no column '9'"),
        ({"columns": {"displacement": 2, "velocity": 2}}, "cannot be both"),
        ({"units": {"displacement": "furlong"}}, "'furlong'"),
        ({"units": {"displacement": "m/s"}}, "'m/s'"),
        ({"columns": {"time": 1}, "rate": 5.0}, "both given"),
        ({"encoding": "klingon"}, "klingon"),
        ({"skip_rows": 10_000}, "fewer"),
    ],
)
def test_an_option_that_does_not_fit_gets_a_sentence(
    tmp_path: Path, options: dict[str, object], word: str
) -> None:
    assert word in refusal(tmp_path, table("time_s,displacement_m", T, U), **options)


@pytest.mark.parametrize(
    "options",
    [
        {"columns": {"colour": 1}},
        {"rate": 0.0},
        {"rate": float("nan")},
        {"decimal": ";"},
        {"delimiter": "ab"},
        {"delimiter": ",", "decimal": ","},
        {"skip_rows": -1},
    ],
)
def test_options_that_contradict_themselves_are_refused_at_once(options: dict[str, object]) -> None:
    with pytest.raises(ImportProblem):
        ImportOptions(**options)  # type: ignore[arg-type]


def test_a_hundred_thousand_rows_with_decimal_commas_are_read_whole(tmp_path: Path) -> None:
    t = np.arange(100_000) / 1000.0
    rows = "".join(f"{a:.3f};{b:.6f};{c:.4f}\n" for a, b, c in zip(t, np.sin(t), np.cos(t), strict=True))
    recording = load(tmp_path, "Zeit [s];Weg [mm];Beschleunigung [g]\n" + rows.replace(".", ","))
    assert recording.samples.shape == (2, 100_000)
    assert recording.valid.all()
    assert recording.samples[0, -1] == pytest.approx(1e-3 * np.sin(t[-1]), abs=1e-9)
