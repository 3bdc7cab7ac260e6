"""Long releases, which are fitted in segments, diagnosed together: what is left out is a session, not a segment."""

import pytest

from identify.diagnosis.diagnose import diagnose
from identify.effects.stiffness import CUBIC_STIFFNESS
from identify.fitting.validation import leave_one_out
from identify.free_decay import FreeDecay
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw
from station.results.diagnosis_document import diagnosis_document


@pytest.mark.slow
def test_the_document_of_two_long_releases_has_a_line_for_each_session():
    fixed = {"seconds": 24.0, "mu_0": 0.02, "mu_1": 0.05}
    samples = [draw(None, 0.0, 4, amplitude=amplitude, **fixed) for amplitude in (0.02, 0.015)]
    decays = tuple(prepare(FreeDecay(s.rate, s.displacement, s.acceleration)) for s in samples)
    found = diagnose(decays, library=(*(t.effect for t in base_model().terms), CUBIC_STIFFNESS))
    assert len(found.final.windows) == 4  # two segments of each
    document = diagnosis_document(("large", "small"), found, left_out=leave_one_out(found.final))
    assert [one.session for one in document.held_out] == ["large", "small"]
    # Nothing is hidden: each is predicted to the floor, and to the own error of the physics that is held.
    assert [one.chi2 for one in document.held_out] == pytest.approx([1.0, 1.0], abs=0.5)
