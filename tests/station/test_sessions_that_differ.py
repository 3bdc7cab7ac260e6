"""Sessions whose springs differ: the kept diagnosis has the spring and damper of each by the session's name."""

import pytest

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.free_decay import FreeDecay
from mocks.generate import draw
from station.results.diagnosis_document import DiagnosisDocument, diagnosis_document
from station.story.engineering_values import UNKNOWN
from station.text.diagnosis_text import told

K = (612.0, 614.5)


@pytest.fixture(scope="module")
def found():
    rig = {"mu_0": 0.05, "mu_1": 0.25, "seconds": 5.0}
    samples = [draw(None, 0.0, 90 + i, stiffness=k, amplitude=0.02, **rig) for i, k in enumerate(K)]
    decays = [FreeDecay(s.rate, s.displacement, s.acceleration) for s in samples]
    return diagnose(decays, library=(find_effect("cubic_stiffness"),))


def test_each_session_is_kept_with_its_own_spring_and_damper(found):
    document = DiagnosisDocument.model_validate_json(
        diagnosis_document(("cold", "warm"), found).model_dump_json()
    )
    springs = {o.session: o for o in document.of_sessions if o.parameter == "linear_stiffness.k"}
    assert [springs[name].value.value for name in ("cold", "warm")] == pytest.approx(K, abs=0.05)
    assert springs["warm"].percent == pytest.approx(50.0 * (K[1] - K[0]) / 613.25, rel=0.05)
    assert springs["cold"].value.unit == "1/s^2"
    assert "Between releases the spring differs by ±0.2" in document.explanation
    assert "k of linear stiffness: cold -0.2" in str(told(document, UNKNOWN).brief)
