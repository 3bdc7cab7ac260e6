"""What stands in a terminal: twelve lines, eighty columns, whatever letters it has."""

import io
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hidden import DUFFING
from rich.console import Console

from station.cli import run
from station.text.content import Facts, Paragraph, Table, Told, markdown
from station.text.layout import show_parts

MOST_LINES = 12


@pytest.fixture
def session(diagnosed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return shutil.copytree(diagnosed, tmp_path / "sessions" / DUFFING.stem)


@pytest.mark.usefixtures("among_few")
@pytest.mark.parametrize(
    "line", [("compare",), ("diagnose",), ("diagnose", "--model", "usual"), ("compare", "--model", "usual")]
)
def test_what_is_asked_for_most_takes_twelve_lines(session, capsys, line):
    command, *options = line
    assert run([command, DUFFING.stem, *options]) == 0
    brief = capsys.readouterr().out.splitlines()
    assert len(brief) <= MOST_LINES
    assert max(map(len, brief)) <= 80
    assert brief[-1].startswith(" next: station ")
    assert run([command, DUFFING.stem, *options, "--full"]) == 0
    full = capsys.readouterr().out.splitlines()
    assert len(full) > len(brief)
    assert full[0] == brief[0]


def test_a_terminal_without_other_letters_is_written_to_all_the_same(session):
    here = str(Path(__file__).parents[2])
    environment = (
        os.environ | {"PYTHONPATH": here} | {"LC_ALL": "C", "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    )
    command = [sys.executable, "-m", "station", "identify", str(session)]
    ended = subprocess.run(command, capture_output=True, env=environment, cwd=session.parent, check=False)
    assert ended.returncode == 0, ended.stderr
    text = ended.stdout.decode("ascii")
    assert "N/m" in text or "1/s" in text
    assert max(map(len, text.splitlines()[:-1])) <= 80


def test_a_result_reads_the_same_in_markdown():
    told = Told("Nothing is missing", "good", (Facts((("noise", "1 ± 0.04"),)), Paragraph("so", label="why"),
                Table("", ("", "% of motion"), (("usual", "0.9"),))))  # fmt: skip
    text = markdown(told.brief)
    assert "**noise**: 1 ± 0.04" in text
    assert "**why**: so" in text
    assert "|  | % of motion |\n| --- | ---: |\n| usual | 0.9 |" in text


def test_names_break_at_blanks_where_values_are_wide():
    value = "(-3.48 ± 0.23) × 10¹⁰"
    table = Table(
        "", ("", "unit", "wavelet", "restoring force"), (("viscous damping", "1/s", value, value),), texts=2
    )
    console = Console(width=60, file=io.StringIO())
    show_parts(console, [table])
    rows = console.file.getvalue().splitlines()
    assert [row.split()[0] for row in rows[1:]] == ["viscous", "damping"]
    assert value in rows[1]


def test_the_last_column_of_a_wide_table_is_not_cut_off():
    numbers = tuple(f"{n}.2345 ± 0.0001" for n in range(1, 5))
    wide = Table(
        "", ("effect", "force", "share", "loss", "frequency"), (("position_dependent_damping", *numbers),)
    )
    console = Console(width=80, record=True, file=io.StringIO())
    show_parts(console, [wide])
    written = console.export_text().split()
    assert all(word in written for number in numbers for word in number.split())


def test_words_give_way_to_numbers_where_a_table_fills_the_line():
    head = ("session", "this one\nis", "% of motion,\nusual model", "\nthis model", "times noise,\nusual model",
            "\nthis model")  # fmt: skip
    rows = (
        ("pendulum_48deg_run", "better", "8.24", "5.14", "13.7", "8.57"),
        ("b", "alike", "99", "9", "32", "327"),
    )
    said = io.StringIO()
    show_parts(Console(file=said, width=80), [Table("", head, rows, texts=2)])
    written = said.getvalue().split()
    assert {"8.57", "327"} <= {*written}
    assert written.count("model") == 4


def test_words_beside_a_path_that_is_longer_than_a_line_are_printed_and_the_path_is_not_folded():
    path = f"/measurements/{'a' * 90}/spindle:"
    console = Console(width=80, file=io.StringIO())
    show_parts(
        console, [Table("", ("", ""), ((path, "8 files checked"), ("", "raw.log is damaged")), texts=2)]
    )
    rows = console.file.getvalue().splitlines()
    assert [row.split(maxsplit=1) for row in rows] == [[path, "8 files checked"], ["raw.log", "is damaged"]]
