"""Kept results: what is written is read back; what was altered, or is older, is refused in a sentence."""

import json
from dataclasses import replace

import numpy as np
import pytest
from synthetic import identification

from daq.recording import Channel, Recording
from daq.session import Session
from identify.estimate import Estimate
from identify.model.model import base_model
from station.exits import UsageProblem
from station.results.diagnosis_document import NAME, read_diagnosis, refused_document
from station.results.documents import EstimateDocument, keep_document
from station.results.identification_document import KeptIdentification, identification_document

DOCUMENT = refused_document(("a", "b"), base_model(), "two cycles are too few")


@pytest.fixture
def session(tmp_path):
    samples = 0.02 * np.cos(np.arange(300) / 10)[None, :]
    recording = Recording(256.0, (Channel("u", "displacement", "m"),), samples, np.ones(300, dtype=bool))
    return Session.create_imported(tmp_path / "one", recording, None)


def test_a_session_without_a_diagnosis_has_none(session):
    assert read_diagnosis(session) is None


def test_a_diagnosis_comes_back_as_it_was_written(session):
    keep_document(session, NAME, DOCUMENT)
    assert read_diagnosis(session) == DOCUMENT
    assert json.loads((session.results / NAME).read_text())["format"] == 1


@pytest.mark.parametrize("missing", ["format", "verdict", "suspects", "rivals", "next_experiment"])
def test_a_diagnosis_of_another_version_is_refused_in_a_sentence_that_says_what_to_do(session, missing):
    older = DOCUMENT.plain()
    del older[missing]
    session.write_result(NAME, json.dumps(older))
    with pytest.raises(UsageProblem, match=r"one: results/diagnosis\.json .*another version.*diagnose again"):
        read_diagnosis(session)


@pytest.mark.parametrize(
    "text", ["", "[]", "null", '{"format": 2}', "\x00", '{"format": 1, "verdict": "guilty"}']
)
def test_a_diagnosis_that_was_altered_is_refused(session, text):
    session.write_result(NAME, text)
    with pytest.raises(UsageProblem, match="altered"):
        read_diagnosis(session)


def test_a_number_that_json_cannot_hold_is_null():
    known = EstimateDocument.model_validate(Estimate(1.5, np.inf, "m"))
    assert json.loads(known.model_dump_json()) == {"value": 1.5, "std": None, "unit": "m"}


def test_an_identification_keeps_what_was_found_and_what_was_not():
    found = replace(identification(), wavelet=None, refusals={"wavelet": "too short"})
    document = identification_document("one", found)
    assert KeptIdentification.model_validate(document).effects == ()
    assert document["wavelet"] is None
    assert document["refusals"] == {"wavelet": "too short"}
    assert document["restoring_force"]["stiffness"]["value"] == found.restoring_force.stiffness.value
    assert document["restoring_force"]["stiffness_by_order"]["1"]["unit"] == "N/m"
    assert document["alignment"]["lag_s"]["value"] == found.alignment.lag.value
