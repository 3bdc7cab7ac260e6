"""Every sentence of the source read as an editor would: what must not reach a person, word by word."""

import re

import pytest
from sentences import sentences

BANNED = {
    "an error is written ±": r"\+-\s*(\d|\{\})|(\d|\{\}) \+- ",
    "one sign is enough": r"±\s*\+-|±\s*±",
    "errors of a library": r"ValidationError|pydantic|Traceback \(|NoneType|LinAlgError|\d+ validation error",
    "no word for odds without a share": r"\bdecisive\b",
    "states without their fact": r"the sign of the first is|as it was written|at any of",
    "no private poetry": r"\b(envelope is opened|gets it, and|no force that anyone|larger than any|is called so)\b",
    "no apology, no shout": r"(?i)\b(oops|sorry|please|unfortunately|hopefully)\b|!!|\bWow\b",
    "what leaves, by name": r"[Ww]hat the (rebuilt decay|fit) leaves",
    "twice the same": r"(?i)\brelease the mass \(release\b|\breleased \(released\b",
    "no loose ends": r"\b(TODO|FIXME|XXX)\b",
}


@pytest.fixture(scope="module")
def said():
    return sentences()


def test_the_sentences_are_found(said):
    assert len(said) > 1000
    assert any("a fault of this program" in one.text for one in said)
    assert any(
        one.text == "{} has more than {} entries" or "do not quote its values" in one.text for one in said
    )


@pytest.mark.parametrize("rule", BANNED)
def test_no_sentence_of_the_program_would_make_an_engineer_smile(said, rule):
    found = [f"{s.file}:{s.line}: {s.text}" for s in said if re.search(BANNED[rule], s.text)]
    assert not found, "\n".join(found)


def test_a_frequency_a_length_and_a_time_have_their_unit(said):
    """A number that is put in before the word for a quantity has its unit after it."""
    wrong = [s for s in said if re.search(r"(rate|frequency|duration) of \{\}(?! (Hz|s\b|\{\}))", s.text)]
    assert not wrong, wrong
