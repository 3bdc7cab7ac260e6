"""The paper's tables: Table 1 line by line, Table 2 its mean and standard deviation, as text, LaTeX and JSON."""

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from identify.estimate import Estimate
from station.story.engineering_values import Weighing
from station.text import table
from station.text.layout import show_parts

# The paper's Table 1, its nine releases: mu_0, mu_1, K by the wavelet and by the restoring force.
WT = [
    (0.13, 0.28, 13104), (0.12, 0.28, 13118), (0.12, 0.26, 13121), (0.11, 0.29, 13184), (0.12, 0.28, 13113),
    (0.14, 0.28, 13091), (0.13, 0.29, 13107), (0.14, 0.27, 13090), (0.14, 0.26, 13110),
]  # fmt: skip
RFS = [
    (0.12, 0.27, 13099), (0.12, 0.27, 13131), (0.12, 0.24, 13126), (0.11, 0.25, 13206), (0.12, 0.29, 13127),
    (0.14, 0.30, 13073), (0.13, 0.30, 13080), (0.13, 0.30, 13093), (0.13, 0.26, 13096),
]  # fmt: skip
AMPLITUDES = (-0.025, -0.02, -0.015, -0.005, 0.02, 0.025, None, None, None)


def identified(amplitude, mass, wavelet, restoring_force):
    """Return an identification, of which the tables need little."""
    return SimpleNamespace(
        amplitude=amplitude, decay=SimpleNamespace(unit="m"), weighing=Weighing(mass), adequacy=None,
        wavelet=wavelet and method(wavelet), restoring_force=restoring_force and method(restoring_force),
    )  # fmt: skip


def method(values):
    mu_0, mu_1, stiffness = values
    damping = (Estimate(mu_0, 0.001, "m/s^2"), Estimate(mu_1, 0.002, "1/s"))
    return SimpleNamespace(stiffness=Estimate(stiffness, 1.0, "N/m"), damping=damping)


def as_text(tables):
    out = io.StringIO()
    show_parts(Console(file=out, width=80), table.in_pieces(tables))
    return out.getvalue()


@pytest.fixture
def documents():
    return [
        (f"release_{number}", identified(amplitude, 21.36, wt, rfs))
        for number, (wt, rfs, amplitude) in enumerate(zip(WT, RFS, AMPLITUDES, strict=True), start=1)
    ]


@pytest.fixture
def plain(documents):
    return table.make_tables(documents, plain=True)


@pytest.fixture
def tables(documents):
    return table.make_tables(documents)


def test_table_2_of_the_papers_table_1_is_the_papers_table_2(plain):
    wavelet, force = plain.table_2
    assert wavelet["K"]["mean"] == pytest.approx(13115.3, abs=0.1)
    assert wavelet["K"]["std"] == pytest.approx(28, abs=0.5)
    assert force["K"]["mean"] == pytest.approx(13114.6, abs=0.1)
    assert force["K"]["std"] == pytest.approx(40, abs=0.5)
    assert wavelet["mu_0"]["mean"] == pytest.approx(0.13, abs=0.005)
    assert force["mu_0"]["mean"] == pytest.approx(0.12, abs=0.005)
    assert wavelet["mu_1"]["mean"] == pytest.approx(0.277, abs=0.0005)
    assert force["mu_1"]["mean"] == pytest.approx(0.276, abs=0.0005)


def test_text_names_every_release_and_both_methods_within_80_columns(tables):
    text = as_text(tables)
    assert all(f"release_{number}" in text for number in range(1, 10))
    assert "13115" in text
    assert "N/m" in text
    assert all(len(line) <= 80 for line in text.splitlines())


def test_latex_has_as_many_cells_in_every_line_as_in_its_head(tables):
    for tabular in table.as_latex(tables).split("\\begin{tabular}")[1:]:
        lines = [line for line in tabular.splitlines() if "&" in line]
        assert len({line.count("&") for line in lines}) == 1
    assert "release\\_1" in table.as_latex(tables)


def test_json_has_both_tables_with_units(plain):
    assert plain.table_1[0]["K (WT)"] == Estimate(13104, 1.0, "N/m")
    assert plain.table_1[0]["mu_1 (WT)"] == Estimate(0.28, 0.002, "1/s")
    assert plain.table_2[0]["method"] == "WT"
    assert plain.table_2[1]["K"]["unit"] == "N/m"


def test_people_read_friction_and_damping_in_newtons_where_the_mass_is_known(tables, plain):
    assert tables.units == {"mu_0": "N", "mu_1": "N s/m", "K": "N/m"}
    assert tables.table_2[0]["mu_0"]["mean"] == pytest.approx(21.36 * plain.table_2[0]["mu_0"]["mean"])
    without = table.make_tables([("a", identified(0.01, None, WT[0], RFS[0]))])
    assert without.units == {"mu_0": "m/s^2", "mu_1": "1/s", "K": "N/m"}


def test_a_method_that_refused_leaves_an_empty_cell_and_the_others_stand():
    documents = [("a", identified(0.01, 1.0, None, (0.1, 0.2, 100.0)))]
    tables = table.make_tables(documents)
    assert tables.table_1[0]["mu_0 (WT)"] is None
    assert tables.table_2[0] == {"method": "WT", "mu_0": None, "mu_1": None, "K": None}
    for text in (as_text(tables), table.as_latex(tables)):
        assert "100" in text


def test_releases_of_which_neither_method_found_anything_are_told_all_the_same():
    documents = [(name, identified(0.01, 1.0, None, None)) for name in "ab"]
    tables = table.make_tables(documents)
    assert tables.units == {}
    assert [row["session"] for row in tables.table_1] == ["a", "b"]
    assert table.in_pieces(tables)
