"""The keys of `--json` that the page of commands names are those of the documents."""

import re

import pytest

from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw
from station.operations.diagnosing import comparison_document
from station.results.campaign_document import CampaignDocument
from station.results.diagnosis_document import DiagnosisDocument
from station.results.documents import Document
from station.results.guide_document import GuideDocument
from station.results.identification_document import identification_document
from station.results.validation_document import ValidationDocument
from station.story.pipeline import KnownModel, compare
from tests.docs.test_pages import COMMANDS_PAGE
from tests.station.synthetic import identification

OF_EVERY_DOCUMENT = {
    "format",
    "session",
    "sessions",
    "rivals",
    "expressions",
    "model_is",
    "model_remark",
}
"""Keys that the page states once for all commands, or that repeat a part that it names."""


@pytest.mark.parametrize(
    ("command", "document"),
    [
        ("diagnose SESSION...", DiagnosisDocument),
        ("validate MODEL SESSION...", ValidationDocument),
        ("campaign [FOLDER | SESSION...]", CampaignDocument),
        ("guide", GuideDocument),
    ],
)
def test_the_keys_of_a_command_are_those_of_its_document(command: str, document: type[Document]) -> None:
    check_page(command, set(document.model_fields))


def test_the_keys_of_an_identification_are_those_on_the_page() -> None:
    check_page("identify SESSION", set(identification_document("one", identification())))


def test_the_keys_of_a_comparison_are_those_on_the_page() -> None:
    sample = draw(None, 0.0, 1)
    prepared = prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration))
    compared = compare("one", prepared, KnownModel(base_model()))
    check_page("compare SESSION", set(comparison_document(compared)))


def check_page(command: str, fields: set[str]) -> None:
    section = COMMANDS_PAGE.read_text(encoding="utf-8").split(f"## `station {command} --json`\n")[1]
    rows = re.findall(r"^\| (`.+?) \|", section.split("\n## ")[0], re.MULTILINE)
    named = {key for row in rows for key in re.findall(r"`(\w+)`", row)}
    assert named <= fields | OF_EVERY_DOCUMENT, "keys on the page that no document has"
    assert fields - OF_EVERY_DOCUMENT <= named, "keys of the document that the page leaves out"
