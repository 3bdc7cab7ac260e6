"""What the documentation site needs beyond Markdown, without a network: more pages, formulas, a check.

MkDocs calls these functions while it builds (`hooks` in mkdocs.yml). README, CONTRIBUTING and CHANGELOG stand at the
root of the repository and become pages; so do the rooms of the API reference and notebooks. LaTeX becomes MathML,
which browsers draw by themselves. A page that would load anything from elsewhere ends the build.
"""

from __future__ import annotations

import html
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page

sys.path.insert(0, str(Path(__file__).parent))

from effects_table import with_effects
from notebook_page import page_of_notebook
from outside_sources import outside_sources
from reference_pages import reference_pages

ROOT_PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "contributing.md", "CHANGELOG.md": "changelog.md"}
"""Pages at the root of the repository, and what they are called on the site."""

FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages of the repository's root, of the API reference, and of each notebook."""
    from mkdocs.structure.files import File

    docs = Path(config.docs_dir)
    pages: dict[str, str | bytes] = dict(reference_pages(docs.parent))
    for source, page in ROOT_PAGES.items():
        pages[page] = with_links_of_the_site((docs.parent / source).read_text(encoding="utf-8"))
    for notebook in sorted(docs.glob("*.ipynb")):
        files.remove(files.src_uris[notebook.name])
        text, pictures = page_of_notebook(notebook.read_text(encoding="utf-8"), notebook.stem)
        pages |= {f"{notebook.stem}.md": text, **pictures}
    for name, content in pages.items():
        files.append(File.generated(config, name, content=content))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lead links to notebooks to their pages, put in the effects, and write tables as Python-Markdown reads them."""
    return with_bars_in_code(with_pages_of_notebooks(with_effects(markdown)))


def on_page_content(content: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Draw the formulas of a page."""
    return with_formulas(content)


def on_post_build(config: MkDocsConfig) -> None:
    """End the build when a page or style sheet would load something from elsewhere."""
    from mkdocs.exceptions import PluginError

    site = Path(config.site_dir)
    found = {
        path.relative_to(site).as_posix(): outside_sources(path.read_text(encoding="utf-8"), path.suffix)
        for path in sorted(site.rglob("*"))
        if path.suffix in (".html", ".css")
    }
    guilty = [f"{path}: {', '.join(sources)}" for path, sources in found.items() if sources]
    if guilty:
        raise PluginError("loaded from elsewhere:\n" + "\n".join(guilty))


def with_links_of_the_site(text: str) -> str:
    """Return a page of the root with its links as they are among the pages of the site."""
    for source, page in ROOT_PAGES.items():
        text = text.replace(f"]({source}", f"]({page}")
    return text.replace("](docs/", "](")


def with_pages_of_notebooks(markdown: str) -> str:
    """Return a page whose links to notebooks of the repository lead to the pages that are made of them."""
    return re.sub(r"(\]\([^)\s:]+)\.ipynb(?=[)#])", r"\1.md", markdown)


def with_bars_in_code(markdown: str) -> str:
    """Return a page with the escaped bars of code in its tables as plain ones: here, unlike elsewhere, they are shown so."""
    rows = (
        re.sub(r"`[^`]*`", lambda code: code[0].replace("\\|", "|"), line) if line.startswith("|") else line
        for line in markdown.split("\n")
    )
    return "\n".join(rows)


def with_formulas(content: str) -> str:
    """Return HTML with every LaTeX formula as MathML."""
    return FORMULA.sub(_formula, content)


def _formula(found: re.Match[str]) -> str:
    from latex2mathml.converter import convert

    display = found[2] == "["
    mathml = convert(html.unescape(found[3]).strip(), display="block" if display else "inline")
    return f'<div class="formula">{mathml}</div>' if display else mathml
