"""Small parts of the page: what is said of a suspect, stored sessions, the scope, doubles, colours."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from daq.capture import CaptureSettings
from daq.errors import DataLost, OperatorError
from daq.recording import Channel
from daq.session import Session, list_sessions
from identify.effects.library import LIBRARY, find_effect
from identify.formatting import plain_name, sentence_case
from identify.model.model import Model, Term
from identify.residual import explained_words
from station.exits import UsageProblem
from station.results.diagnosis_document import DiagnosisDocument, refused_document
from station.settings import Settings
from station.story.pipeline import silent
from station.workbench import session_menu
from station.workbench.capture_run import ScopeObserver
from station.workbench.opened_session import open_session
from station.workbench.session_list import outline
from station.workbench.statements import says_of
from station.workbench.tasks import look

CSS = Path(session_menu.__file__).parent / "static" / "bench.css"


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (229.0, 1.05, "would explain all of it"),
        (229.0, 1.4, "would explain 99.8 %"),
        (229.0, 100.0, "would explain 57 %"),
        (229.0, 226.0, "would explain 1 %"),
        (229.0, 229.1, "would explain nothing"),
        (1.0, 0.9, ""),
        (229.0, None, ""),
    ],
)
def test_a_suspect_is_said_to_explain_a_share_of_what_is_above_the_noise(before, after, words):
    assert explained_words(before, after, 0.06) == words


def test_an_effect_is_found_by_the_name_on_its_card():
    for effect in LIBRARY:
        assert find_effect(sentence_case(plain_name(effect.name))) is effect


@pytest.fixture
def kept(tmp_path):
    from station.operations.examples import open_example

    return open_example("simulated_plain", tmp_path / "sessions").folder


def test_a_session_is_renamed_described_and_put_into_a_bin_from_which_it_comes_back(kept):
    place = session_menu.rename(kept, " Motor 2/links ")
    assert (place.name, Session.open(place).info.name) == ("Motor_2_links", "Motor_2_links")
    Session.open(place).update(remarks="bolt M8 loose", mass_kg=3.5)
    assert (Session.open(place).info.remarks, Session.open(place).info.mass_kg) == ("bolt M8 loose", 3.5)
    binned = session_menu.to_bin(place)
    assert list_sessions(place.parent) == ()
    binned.rename(place)
    assert [summary.folder for summary in list_sessions(place.parent)] == [place]


def joint(effects, **numbers):
    """Make the diagnosis of two releases of the usual model, which leaves 10 times the noise in them."""
    suspect = {"effect": "cubic_stiffness", "title": "", "kind": "physics", "channel": None, "evidence": 9.0}
    suspect |= {
        "error_after": 25.0,
        "parameters": {},
        "confusable_with": [],
        "plausible": True,
        "claimed": True,
    }
    known = {
        "verdict": "missing_effect",
        "named": ["cubic_stiffness"],
        "error": {"chi2": 100.0, "chi2_std": 0.05},
    }
    known |= {"suspects": [suspect | {"model": None, "motion_percent": 1.0} | numbers]}
    known |= {"noise_floor": {"chi2_std": 0.05, "channels": {}}}
    return DiagnosisDocument.model_validate(
        refused_document(("one", "two"), Model(tuple(map(Term, map(find_effect, effects)))), "").plain()
        | known
    )


def test_what_releases_show_together_is_a_share_of_what_the_model_leaves_in_all_of_them(kept):
    view = look(Settings(), silent, kept)
    view = replace(view, diagnosis=joint(view.ladder.top.effects))
    said = says_of(view, "")["cubic_stiffness"]
    assert said["words"] == "would explain 76 %"  # (100 - 25) of (100 - 1)
    assert "2 releases together: 5.00 times the noise" in said["what"]


@pytest.mark.parametrize("wanted", ["", "  ", "../elsewhere/.."])
def test_a_name_that_is_none_leaves_the_session_where_it_is(kept, wanted):
    if not wanted.strip():
        with pytest.raises(UsageProblem, match="needs a name"):
            session_menu.rename(kept, wanted)
    else:
        assert session_menu.rename(kept, wanted).parent == kept.parent


@pytest.mark.parametrize(
    ("left", "said"), [(None, "is missing"), (2000, "is shorter than when it was written")]
)
def test_a_raw_log_that_was_damaged_is_named_with_what_to_do(kept, left, said):
    raw = kept / "raw.log"
    before = raw.read_bytes()
    raw.unlink()
    if left is not None:
        raw.write_bytes(before[:left])
    with pytest.raises(DataLost, match=rf"raw.log, which .*, {said}: import source/.* again"):
        open_session(Settings(), kept)


def test_a_mass_below_nothing_is_refused_in_words(kept):
    with pytest.raises(OperatorError, match=r"mass_kg.*greater than 0"):
        Session.open(kept).update(mass_kg=-3.0)


def test_the_scope_knows_zero_noise_and_the_swing_that_counts_as_a_release():
    channel = Channel("displacement", "displacement", "m", low=-0.05, high=0.05)
    watched = ScopeObserver(CaptureSettings())
    watched.connected(None, (channel,))
    watched.state("resting", "")
    noise = np.random.default_rng(5).normal(scale=2e-6, size=(1, 800))
    watched.block(0, 0.003 + noise)
    found = watched.now.scope
    assert found.unit == "mm"
    assert found.zero == pytest.approx(3.0, abs=1e-3)
    assert found.noise == pytest.approx(2e-3, rel=0.1)
    assert found.level == pytest.approx(1.0)  # one per cent of a range of 100 mm
    assert 2 <= len(found.points) <= 700


def test_the_amplitude_in_the_list_is_counted_from_the_rest_at_the_end():
    clock = np.linspace(-10.0, 20.0, 5000)
    swing = 3.0 + 12.0 * np.where(clock < 0.0, 1.0, np.exp(-0.3 * clock) * np.cos(9.0 * clock))
    largest, line = outline(np.where(clock > 19.0, np.nan, swing))
    assert largest == pytest.approx(12.0, rel=0.005)
    assert max(value for value in line if value is not None) == 1.0


def palette(scheme):
    """Return the colours of a scheme by name, as shares of red, green and blue."""
    text = CSS.read_text(encoding="utf-8")
    block = re.search(rf"^{re.escape(scheme)} \{{(.*?)\}}", text, re.S | re.M).group(1)
    return {
        name: [int(value[i : i + 2], 16) / 255 for i in (0, 2, 4)]
        for name, value in re.findall(r"--([\w-]+):#([0-9a-f]{6})", block)
    }


def contrast(first, second):
    """Return the contrast ratio of two colours, WCAG 2.2."""

    def luminance(colour):
        parts = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in colour]
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2]

    light, dark = sorted((luminance(first), luminance(second)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("scheme", [":root", "body.body--dark"])
def test_words_and_lines_stand_out_from_what_is_behind_them(scheme):
    colours = palette(scheme)
    for words in ("ink", "faint", "bad", "good", "accent"):
        for behind in ("paper", "ground", "soft", "chosen", "good-soft"):
            assert contrast(colours[words], colours[behind]) >= 4.5, (words, behind)
    assert contrast(colours["accent"], colours["accent-ink"]) >= 4.5
    for line in ("model", "left"):  # graphics: 3 to 1
        assert contrast(colours[line], colours["paper"]) >= 3.0, line
