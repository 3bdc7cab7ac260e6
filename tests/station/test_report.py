"""The report: one page that needs nothing outside itself, whose numbers are those of the JSON, whoever wrote the names."""

import base64
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hidden import DUFFING, NOTHING

from daq.session import Session
from identify.formatting import SPACE, three_figures, with_error
from station.cli import run
from station.report.write import SECTIONS, write_report
from station.text.numbers import typeset_unit

MASS = 21.36
HOSTILE = '<script>alert("x")</script>'
NAMES = (
    "comparison", "suspects", "ladder", "equation", "setup", "methods", "provenance",
)  # fmt: skip


class Page(HTMLParser):
    """What a page holds: its tags with attributes, its text, its tables as rows of cells."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.text, self.rows, self.sections, self.open = [], [], [], {}, None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        found = dict(attrs)
        self.tags.append((tag, found))
        if tag == "section":
            self.open = found["id"]
            self.sections[self.open] = ""
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_data(self, data):
        self.text.append(data)
        if self.open is not None:
            self.sections[self.open] += data
        if self.rows and self.rows[-1] and self.tags[-1][0] in ("td", "th"):
            self.rows[-1][-1] += data.strip()

    def row(self, first):
        """Return the first row that begins with `first`."""
        return next(row for row in self.rows if row[0] == first)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, among_few):
    """A folder with a diagnosed and refined session of a Duffing spring, and its report."""
    made = tmp_path_factory.mktemp("report")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        patch.delenv("DISPLAY", raising=False)
        patch.delenv("WAYLAND_DISPLAY", raising=False)
        patch.setattr("station.views.viewer.PORT", 9)  # nobody listens there
        assert run(["import", str(DUFFING), "--mass", str(MASS), "--session", "sessions/duffing"]) == 0
        assert run(["diagnose", "duffing"]) == 0
        assert run(["refine", "duffing", "--add", "cubic_stiffness", "--no-viewer"]) == 0
        assert run(["report", "duffing"]) == 0
        yield made


@pytest.fixture(scope="module")
def html(folder):
    return (folder / "sessions" / "duffing" / "results" / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(html):
    return Page(html)


@pytest.fixture
def kept(folder):
    results = folder / "sessions" / "duffing" / "results"
    return lambda name: json.loads((results / f"{name}.json").read_text(encoding="utf-8"))


def value_of(cell):
    """Return value and error of a cell such as "(5.458 ± 0.012) × 10⁴"."""
    text = cell.replace(SPACE, " ")
    raised = {sign: str(number) for number, sign in enumerate("⁰¹²³⁴⁵⁶⁷⁸⁹")} | {"⁻": "-"}
    power = re.search(r"× 10([⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)", text)
    scale = 10.0 ** int("".join(raised[sign] for sign in power.group(1))) if power else 1.0
    value, std = re.match(r"\(?([-\d.]+) ± ([-\d.]+)", text).groups()
    return float(value) * scale, float(std) * scale


def agrees(cell, document):
    """Whether a printed value is that of a document: the error has two figures, and the value its decimals."""
    value, std = value_of(cell)
    last = 10.0 ** (np.floor(np.log10(document["std"])) - 1)
    assert std == pytest.approx(document["std"], rel=0.051)  # two figures: half a unit of 10
    assert (
        abs(value - document["value"]) <= 5.01 * last
    )  # half a unit of the last figure, ten where 99.6 became 100
    return True


def test_nothing_outside_the_page_is_needed_and_no_script_runs(html, page):
    assert not {"script", "link", "iframe", "object", "embed", "base"} & {tag for tag, _ in page.tags}
    for _, attributes in page.tags:
        assert not any(name.startswith("on") for name in attributes)
        for name in ("src", "href"):
            assert attributes.get(name, "#").startswith(("data:", "#"))
    assert "@import" not in html
    assert "url(" not in html


def test_every_picture_is_a_vector_graphic_with_words_for_who_cannot_see_it(page):
    pictures = [attributes for tag, attributes in page.tags if tag == "img"]
    assert len(pictures) > 8
    for picture in pictures:
        assert picture["alt"]
        drawing = base64.b64decode(picture["src"].removeprefix("data:image/svg+xml;base64,"))
        assert b"<svg" in drawing
        assert not re.search(
            rb'(href|src)="(?!#|data:)', drawing
        )  # nor does a picture need anything outside itself


def test_every_section_is_there_in_order_and_holds_something(page):
    assert tuple(name for name in page.sections if name in NAMES) == NAMES
    assert len(SECTIONS) == len(NAMES)
    assert all(len(page.sections[name].split()) > 5 for name in NAMES)
    assert "left-out" not in page.sections


def test_the_identified_parameters_are_those_of_the_json(page, kept):
    document = kept("identification")
    for name, order, unit in (("dry friction μ₀", 0, "N"), ("viscous damping μ₁", 1, "N s/m")):
        row = next(row for row in page.rows if row[0] == name and len(row) == 5)
        assert row[1] == typeset_unit(unit)
        for cell, method in ((2, "wavelet"), (3, "restoring_force")):
            bare = document[method]["damping"][order]
            assert agrees(row[cell], {key: MASS * bare[key] for key in ("value", "std")})
    row = next(row for row in page.rows if row[0] == "stiffness K" and len(row) == 5)
    assert agrees(row[2], document["wavelet"]["stiffness"])
    assert agrees(row[3], document["restoring_force"]["stiffness"])


def test_the_equation_has_the_parameters_of_the_present_model(page, kept):
    entries = kept("model")["effects"]
    for entry in entries:
        (value,) = entry["parameters"].values()
        unit = typeset_unit({"1/s^2": "N/m", "m/s^2": "N", "1/s": "N s/m"}.get(value["unit"], "N/m^3"))
        row = next(r for r in page.rows if r[0] == entry["effect"] and len(r) == 5 and r[4] == unit)
        assert agrees(row[3], {name: MASS * value[name] for name in ("value", "std")})
        assert "per unit mass" not in row[2]
    k3 = MASS * entries[3]["parameters"]["k3"]["value"]
    line = next(text for text in page.text if text.startswith("21.36 ü + "))
    printed = line.replace(SPACE, " ")
    assert "u³ = 0" in printed
    assert f"({k3 / 1e6:.4f} × 10⁶) u³" in printed


def test_the_errors_of_the_comparison_and_the_ladder_are_those_of_the_json(page, kept):
    steps = kept("ladder")["steps"]
    first = steps[0]["error"]
    assert page.row("0")[2:4] == [three_figures(x) for x in (first["motion_percent"], first["chi2"] ** 0.5)]
    error = kept("comparison")["error"]  # of the current model
    assert error["motion_percent"] == pytest.approx(steps[-1]["error"]["motion_percent"], rel=0.01)
    assert f"leaves {three_figures(error['motion_percent'])} % of the motion" in page.sections["comparison"]


def test_the_checksums_are_those_of_the_files(page, folder):
    files = json.loads((folder / "sessions" / "duffing" / "manifest.json").read_text())["files"]
    for name in ("raw.log", "session.json", "results/identification.json", "source/" + DUFFING.name):
        assert page.row(name)[1] == files[name]["sha256"]


def test_the_report_is_sealed_with_the_session(folder):
    assert run(["verify", str(folder / "sessions" / "duffing")]) == 0


@pytest.mark.usefixtures("undrawn")
def test_what_was_not_done_says_why_in_the_page_and_in_the_json(folder, capsys):
    assert run(["import", str(NOTHING), "--session", "sessions/plain"]) == 0
    capsys.readouterr()
    assert run(["report", "plain", "--output", "plain.html", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["report"] == str(folder / "plain.html")
    assert set(told["left_out"]) == {"suspects", "ladder"}
    page = Page((folder / "plain.html").read_text(encoding="utf-8"))
    assert "station diagnose" in page.sections["suspects"]
    assert "station refine" in page.sections["ladder"]
    assert any("all is per unit mass" in text for text in page.text)


def test_a_record_of_nothing_says_so_and_still_shows_the_record(folder, capsys):
    quiet = np.column_stack([np.arange(800) / 256, 1e-5 * np.random.default_rng(3).standard_normal(800)])
    np.savetxt(folder / "quiet.csv", quiet, delimiter=",", header="time_s,displacement_m", comments="")
    assert run(["report", "quiet.csv", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert {"identification", "comparison"} <= set(told["left_out"])
    page = Page((folder / "sessions" / "quiet" / "results" / "report.html").read_text(encoding="utf-8"))
    assert "Nothing can be identified" in page.sections["setup"]
    assert any(tag == "img" for tag, _ in page.tags)


def test_names_from_strangers_are_shown_as_they_stand_and_do_nothing(folder):
    header = f'time_s,"{HOSTILE} $\\frac{{$ displacement_m"'
    table = np.loadtxt(DUFFING, delimiter=",", skiprows=1)[:, :2]
    np.savetxt(folder / "hostile.csv", table, delimiter=",", header=header, comments="", fmt="%.9g")
    options = ["--operator", HOSTILE, "--specimen", f"{HOSTILE} $\\alpha$", "--column", "displacement=2"]
    assert (
        run(["import", "hostile.csv", "--unit", "displacement=m", "--session", "sessions/hostile", *options])
        == 0
    )
    session = Session.open(folder / "sessions" / "hostile")
    document = json.loads((folder / "sessions" / "duffing" / "results" / "diagnosis.json").read_text())
    document["suspects"][0]["title"] = document["explanation"] = HOSTILE
    document["suspects"][1]["effect"] = f"$\\frac{{{HOSTILE}"
    session.write_result("diagnosis.json", json.dumps(document))
    text = write_report(session)[0].read_text(encoding="utf-8")
    page = Page(text)
    assert "<script" not in text
    assert "script" not in {tag for tag, _ in page.tags}
    assert HOSTILE in page.sections["suspects"]
    assert page.text.count(HOSTILE) > 1  # the operator's name


@pytest.mark.usefixtures("undrawn")
def test_a_kept_diagnosis_that_cannot_be_read_leaves_its_section_out(folder):
    session = Session.open(folder / "sessions" / "duffing")
    before = (session.results / "diagnosis.json").read_text(encoding="utf-8")
    try:
        session.write_result("diagnosis.json", '{"suspects": 3, "verdict": "none"}')
        page = Page(write_report(session, folder / "damaged.html")[0].read_text(encoding="utf-8"))
    finally:
        session.write_result("diagnosis.json", before)
    assert "another version wrote it; diagnose again" in page.sections["suspects"]
    assert "ü + " in page.sections["equation"]


def test_a_session_that_does_not_exist_is_refused_in_one_sentence(folder, capsys):
    assert run(["report", "nobody"]) == 2
    assert "nobody" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (13115.04, 2.08, "13115.0 ± 2.1"),
        (0.27654, 0.0021, "0.2765 ± 0.0021"),
        (54576.5, 122.8, "(5.458 ± 0.012) × 10⁴"),
        (0.1, 0.0996, "0.10 ± 0.10"),
        (12.3, 9.96, "12 ± 10"),
        (-3.2e-5, 4e-7, "(-3.200 ± 0.040) × 10⁻⁵"),
        (5.0, float("inf"), "5 (error unknown)"),
        (float("nan"), 1.0, "unknown"),
    ],
)
def test_a_value_is_rounded_to_two_figures_of_its_error(value, std, text):
    assert with_error(value, std).replace(SPACE, " ") == text


def test_units_have_raised_powers():
    assert typeset_unit("1/(m^2 s^2)") == f"1/(m²{SPACE}s²)"
    assert typeset_unit("um") == "µm"
    assert typeset_unit("1") == ""
