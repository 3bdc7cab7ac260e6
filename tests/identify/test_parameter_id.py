import pytest

from identify.effects.library import find_effect
from identify.model.model import Term
from identify.model.parameter_id import ParameterId, nuisance

NAMED = [
    (ParameterId("linear_stiffness", "k"), "linear_stiffness.k"),
    (ParameterId("clipping", "limit", 2), "clipping.limit[2]"),
    (ParameterId("hysteresis", "state0", None, "state"), "hysteresis.state0"),
    (ParameterId("second_mass", "state1", 3, "state"), "second_mass.state1[3]"),
    (ParameterId("", "lag", None, "nuisance"), "lag"),
    (ParameterId("", "acceleration_offset", 11, "nuisance"), "acceleration_offset[11]"),
]


@pytest.mark.parametrize(("id", "name"), NAMED, ids=[name for _, name in NAMED])
def test_a_parameter_is_written_by_its_name(id, name):
    assert str(id) == name


def test_a_release_has_a_number_only_among_several():
    assert str(nuisance("gain")) == "gain"
    assert str(nuisance("gain", 1, 3)) == "gain[1]"
    assert str(nuisance("gain", 1, 3).of_release(0, 1)) == "gain"


def test_values_by_own_names_become_values_by_the_unknowns_names():
    term = Term(find_effect("end_stop"), {"side": 1.0})
    assert term.by_name({"ks": 3.0, "gap": 0.01}) == {"end_stop.ks": 3.0, "end_stop.gap": 0.01}
