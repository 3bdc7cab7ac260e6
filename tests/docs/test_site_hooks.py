"""What the build of the documentation site adds to MkDocs: links of root pages, notebooks, reference pages, a check."""

import base64
import html
import importlib
import json
import re
import sys
from xml.etree import ElementTree

import pytest
from contracts import ROOT

from identify.effects.library import LIBRARY


@pytest.fixture(scope="module")
def tools():
    """The modules of docs/tools, by name; they are no package."""
    sys.path.insert(0, str(ROOT / "docs" / "tools"))
    names = ("site_hooks", "effects_table", "notebook_page", "outside_sources", "reference_pages")
    found = {name: importlib.import_module(name) for name in names}
    sys.path.remove(str(ROOT / "docs" / "tools"))
    return found


@pytest.mark.parametrize(
    "page",
    [
        '<script src="https://cdn.example/x.js"></script>',
        '<script src="//cdn.example/x.js"></script>',
        '<link rel="stylesheet" href="https://fonts.example/css">',
        '<link rel="preconnect" href="https://fonts.example" crossorigin>',
        '<img src="http://pictures.example/a.png">',
        "<style>@import url(https://fonts.example/a.css);</style>",
    ],
)
def test_what_a_page_would_load_from_elsewhere_is_found(tools, page):
    assert len(tools["outside_sources"].outside_sources(page)) == 1


@pytest.mark.parametrize(
    "page",
    [
        '<script src="assets/x.js"></script>',
        '<a href="https://elsewhere.example">a link that a reader may follow</a>',
        '<link rel="canonical" href="https://elsewhere.example/page">',
        "<pre>@import url(https://shown.example) as text</pre>",
        '<svg xmlns="http://www.w3.org/2000/svg"></svg>',
    ],
)
def test_what_a_page_only_names_is_let_pass(tools, page):
    assert tools["outside_sources"].outside_sources(page) == []


def test_a_font_that_a_style_sheet_loads_is_found(tools):
    style = '@font-face { src: url("https://fonts.example/a.woff2") } a { background: url(b.svg) }'
    assert tools["outside_sources"].outside_sources(style, ".css") == ["https://fonts.example/a.woff2"]


def test_links_of_root_pages_are_those_among_the_pages_of_the_site(tools):
    text = "[m](docs/method.md) [c](CONTRIBUTING.md) ![p](docs/pictures/a.png) [w](https://x.example/docs/)"
    expected = "[m](method.md) [c](contributing.md) ![p](pictures/a.png) [w](https://x.example/docs/)"
    assert tools["site_hooks"].with_links_of_the_site(text) == expected


def test_a_link_to_a_notebook_leads_to_its_page(tools):
    text = "[the\ntutorial](tutorial.ipynb), [a part](tutorial.ipynb#part), [theirs](https://x.example/a.ipynb), `b.ipynb`"
    shown = "[the\ntutorial](tutorial.md), [a part](tutorial.md#part), [theirs](https://x.example/a.ipynb), `b.ipynb`"
    assert tools["site_hooks"].on_page_markdown(text, None, None, None) == shown


def test_an_escaped_bar_in_the_code_of_a_table_is_shown_as_a_bar(tools):
    text = "| `v \\|v\\|` | a \\| b |\nno row: `\\|`"
    assert tools["site_hooks"].with_bars_in_code(text) == "| `v |v|` | a \\| b |\nno row: `\\|`"


def test_a_formula_is_drawn_without_a_script(tools):
    page = '<p><span class="arithmatex">\\(a &lt; b\\)</span></p><div class="arithmatex">\\[\\mu_0\\]</div>'
    drawn = tools["site_hooks"].with_formulas(page)
    assert "arithmatex" not in drawn
    assert drawn.count("<math") == 2
    assert 'class="formula"' in drawn
    assert "<msub>" in drawn


def formulas():
    """Every formula of every page, between one or two dollars, outside of code."""
    for page in sorted((ROOT / "docs").rglob("*.md")):
        text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        yield from (formula.strip("$") for formula in re.findall(r"\$\$.+?\$\$|\$[^$\n]+\$", text, re.DOTALL))


@pytest.mark.parametrize("formula", sorted(set(formulas())))
def test_every_formula_of_the_pages_is_understood(tools, formula):
    drawn = tools["site_hooks"].with_formulas(f'<div class="arithmatex">\\[{html.escape(formula)}\\]</div>')
    assert "<math" in drawn
    assert "\\" not in drawn.replace('class="formula"', "")
    ElementTree.fromstring(drawn)


def cell(kind, source, *outputs):
    return {"cell_type": kind, "source": source.splitlines(keepends=True), "outputs": list(outputs)}


def test_a_notebook_becomes_a_page_with_its_outputs_as_saved(tools):
    picture = base64.b64encode(b"\x89PNG").decode()
    cells = [
        cell("markdown", "# A title\n\nand text"),
        cell(
            "code",
            "1 + 1\n",
            {"output_type": "stream", "text": ["printed\n"]},
            {"output_type": "execute_result", "data": {"text/plain": ["2"]}},
            {
                "output_type": "execute_result",
                "data": {"text/html": ["<table></table>"], "text/plain": ["t"]},
            },
            {"output_type": "display_data", "data": {"image/png": picture, "text/plain": ["<Figure>"]}},
        ),
        cell("code", ""),
    ]
    page, pictures = tools["notebook_page"].page_of_notebook(json.dumps({"cells": cells}), "tutorial")
    assert pictures == {"tutorial_0.png": b"\x89PNG"}
    assert page.split("\n\n") == [
        "# A title",
        "and text",
        "```python\n1 + 1\n```",
        "```text\nprinted\n```",
        "```text\n2\n```",
        '<div class="output">\n<table></table>\n</div>',
        "![](tutorial_0.png)\n",
    ]


def test_every_room_of_identify_has_a_page_of_reference_with_all_its_modules(tools):
    pages = tools["reference_pages"].reference_pages(ROOT)
    for folder in (ROOT / "identify").iterdir():
        if (folder / "__init__.py").is_file():
            text = pages[f"reference/identify/{folder.name}.md"]
            modules = [path.stem for path in folder.glob("*.py") if path.stem != "__init__"]
            assert [name for name in modules if f"::: identify.{folder.name}.{name}\n" not in text] == []


def test_the_pages_of_reference_are_those_in_the_navigation(tools):
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    pages = tools["reference_pages"].reference_pages(ROOT)
    assert sorted(re.findall(r" (reference/\S+\.md)\n", navigation)) == sorted(pages)


def test_the_page_of_the_effects_has_a_row_for_each(tools):
    page = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8")
    made = tools["site_hooks"].on_page_markdown(page, None, None, None)
    rows = [line for line in made.splitlines() if re.match(r"\| `\w+` \|.*\|.*\|.*\|", line)]
    for effect in LIBRARY:
        (row,) = (line for line in rows if line.startswith(f"| `{effect.name}` |"))
        assert effect.title in row
        assert effect.symptom in row
        assert effect.equation in row
