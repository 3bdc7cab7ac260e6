"""Model files: what is written is read back, and what is wrong is refused in a sentence."""

import json
import os

import numpy as np
import pytest

from identify.effects.contact import END_STOP
from identify.effects.library import LIBRARY
from identify.effects.sensors import OFFSET_DRIFT
from identify.effects.stiffness import CUBIC_STIFFNESS
from identify.estimate import Estimate
from identify.fitting.fit import Fit
from identify.fitting.parameter_layout import Unknown
from identify.model.model import Model, Term, base_model
from identify.model.parameter_id import ParameterId
from station.exits import UsageProblem
from station.results.documents import to_text
from station.results.models import ModelFile, known_model, model_file, read_model, read_model_file
from station.story.pipeline import KnownModel

VALUES = {
    "linear_stiffness.k": Estimate(613.9, 0.002, "1/s^2"),
    "coulomb_friction.mu_0": Estimate(0.13, 1e-4, "m/s^2"),
    "viscous_damping.mu_1": Estimate(0.277, 3e-4, "1/s"),
    "end_stop.ks": Estimate(171.7, 2.0, "1/s^2"),
    "end_stop.gap": Estimate(0.016, np.inf, "m"),
    "offset_drift.rate": Estimate(-1e-4, 1e-6, "m/s"),
}
MODEL = Model(
    (
        *base_model().terms,
        Term(END_STOP, dict(END_STOP.variants[0])),
        Term(OFFSET_DRIFT, {"channel": "displacement"}),
    )
)


def fitted(model: Model = MODEL, values: dict[str, Estimate] = VALUES) -> Fit:
    """Return a fit that holds nothing but a model and its values."""
    nothing = np.zeros(0)
    unknowns = tuple(
        Unknown(ParameterId(*name.split(".")), value.unit, -np.inf, np.inf, 0.0, -1, True)
        for name, value in values.items()
    )
    return Fit(model, (), unknowns, nothing, nothing, values, 0.0, 1, (), True, (), 25.0)


def changed(**entries):
    """Return the model file with the third effect replaced."""
    document = json.loads(to_text(model_file(fitted())))
    document["effects"][2] = {"effect": "cubic_stiffness", "held": {}, "parameters": {}} | entries
    return document


@pytest.fixture
def file(tmp_path):
    return tmp_path / "model.json"


def test_a_model_comes_back_with_its_terms_and_values(file):
    file.write_text(to_text(model_file(fitted())))
    known = read_model(file)
    assert isinstance(known, KnownModel)
    assert known.model.names == MODEL.names
    assert [dict(term.held) for term in known.model.terms] == [dict(term.held) for term in MODEL.terms]
    assert known.values == {name: estimate.value for name, estimate in VALUES.items()}


def test_an_error_that_is_not_known_is_written_as_null(file):
    document = json.loads(to_text(model_file(fitted())))
    assert document["effects"][3]["parameters"]["gap"] == {"value": 0.016, "std": None, "unit": "m"}


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"effect": "magic"}, "no effect is called 'magic'"),
        ({"effect": "linear_stiffness", "parameters": {"k": {"value": 1.0}}}, "stands in it twice"),
        ({}, "no value for k3"),
        ({"parameters": {"k3": {"value": 1.0}, "q": {"value": 1.0}}}, "has no parameter q"),
        ({"parameters": {"k3": {"value": 1.0}}, "held": {"side": 4.0}}, "`held`"),
        ({"effect": "end_stop", "held": dict(END_STOP.variants[1])}, "no value for"),
        ({"parameters": {"k3": {"value": "import os"}}}, "must be a number"),
        ({"parameters": {"k3": {"value": 1.0}}, "run": "os.system"}, "run"),
    ],
)
def test_an_entry_that_is_wrong_is_named(file, document, words):
    file.write_text(json.dumps(changed(**document)))
    with pytest.raises(UsageProblem, match=words) as refusal:
        read_model(file)
    assert str(file) in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "text", ["", "import os", "[]", '{"format": 2}', '{"format": 1, "effects": []}', "\xff\xfe"]
)
def test_what_is_no_model_is_refused(file, text):
    file.write_text(text, encoding="latin-1")
    with pytest.raises(UsageProblem, match=r"the model .*model\.json"):
        read_model(file)


def test_a_value_that_physics_forbids_is_refused(file):
    file.write_text(json.dumps(changed(effect="quadratic_damping", parameters={"c2": {"value": -1.0}})))
    with pytest.raises(UsageProblem, match="outside"):
        read_model(file)


def test_a_file_that_is_not_there_is_told_so(file):
    with pytest.raises(UsageProblem, match="cannot be read"):
        read_model(file)


def test_a_file_that_is_too_large_is_not_read(file):
    file.write_bytes(b" " * (2 << 20))
    with pytest.raises(UsageProblem, match="larger"):
        read_model(file)


def test_every_effect_of_the_library_can_stand_in_a_file():
    for effect in LIBRARY:
        for variant in effect.variants:
            term = Term(effect, variant)
            values = {f"{effect.name}.{p.name}": Estimate(_inside(p), 0.1, p.unit) for p in term.free}
            one = fitted(Model((term,)), values)
            known = known_model(model_file(one), "it")
            assert known.model.names == (effect.name,)
            assert known.values == {name: estimate.value for name, estimate in values.items()}


def _inside(parameter):
    low = parameter.low if np.isfinite(parameter.low) else -1.0
    high = parameter.high if np.isfinite(parameter.high) else low + 2.0
    return 0.5 * (low + high)


def test_an_expression_is_kept_with_the_model_that_uses_it():
    known = ("magnet = k3*u**3", "unused = a*v")
    from dataclasses import replace

    own = replace(CUBIC_STIFFNESS, name="magnet")
    values = VALUES | {"magnet.k3": Estimate(2.0, 0.1, "1/(m^2 s^2)")}
    one = fitted(base_model().plus(Term(own)), values)
    kept = model_file(one, known)
    assert kept.expressions == known[:1]
    back = known_model(kept, "it")
    assert "magnet" in back.model
    with pytest.raises(UsageProblem, match="it: character 13: the formula cannot be read"):
        known_model(kept.model_copy(update={"expressions": ("magnet = k3*(u",)}), "it")


@pytest.mark.skipif(os.name == "nt", reason="a pipe of POSIX")
def test_a_pipe_in_place_of_a_model_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "model.json")
    with pytest.raises(UsageProblem, match="no plain file"):
        read_model_file(tmp_path / "model.json")


@pytest.mark.parametrize("at", [{}, {"at": -0.1}, {"at": "here"}, {"at": 0.1, "p": 2.0}])
def test_the_motion_at_which_a_law_of_a_family_has_its_strength_is_a_positive_number(at):
    values = {name: {"value": value, "std": None, "unit": ""} for name, value in (("f", 0.3), ("p", 2.5))}
    entry = {"effect": "power_law_stiffness", "parameters": values}
    read = ModelFile.model_validate({"equation": "", "effects": [entry | {"held": {"at": 0.02}}]})
    assert known_model(read, "here").model.terms[0].held == {"at": 0.02}
    with pytest.raises(UsageProblem, match="held"):
        known_model(ModelFile.model_validate({"equation": "", "effects": [entry | {"held": at}]}), "here")
