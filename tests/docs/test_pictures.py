"""The pictures of the pages: none is missing, none is left over, and none is older than what it shows."""

import re

from bench.pictures import MADE_OF, PICTURES, ROOT, fingerprint

PAGES = (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))


def shown():
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    return set(re.findall(r"pictures/([\w.-]+\.(?:png|svg))", text))


def test_every_picture_is_shown_and_every_one_that_is_shown_is_there():
    there = {file.name for file in PICTURES.iterdir() if file.suffix in (".png", ".svg")}
    assert there - {"favicon.svg"} == shown()


def test_the_pictures_were_made_of_the_page_the_report_and_the_viewer_as_they_are():
    assert (PICTURES / MADE_OF).read_text().strip() == fingerprint(), "old pictures: run `make pictures`"
