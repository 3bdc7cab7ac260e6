import pytest

from identify.effects.library import find_effect
from identify.model.model import Term, base_model


def test_the_base_model_is_stiffness_dry_and_viscous_friction():
    assert base_model().names == ("linear_stiffness", "coulomb_friction", "viscous_damping")
    assert base_model().minus("coulomb_friction").names == ("linear_stiffness", "viscous_damping")


def test_adding_and_removing_an_effect_leaves_the_model_it_began_from_alone():
    base = base_model()
    more = base.plus(Term(find_effect("cubic_stiffness")))
    assert more.names == (*base.names, "cubic_stiffness")
    assert more.minus("cubic_stiffness").names == base.names
    assert "cubic_stiffness" in more
    assert "cubic_stiffness" not in base


def test_an_effect_is_added_only_once_a_fault_in_one_channel():
    base = base_model().plus(Term(find_effect("clipping"), {"channel": "acceleration"}))
    with pytest.raises(ValueError, match="clipping is in the model already"):
        base.plus(Term(find_effect("clipping"), {"channel": "displacement"}))


def test_removing_what_is_not_there_says_what_is():
    with pytest.raises(KeyError, match="linear_stiffness, coulomb_friction"):
        base_model().minus("freeplay")


def test_a_held_parameter_is_not_fitted():
    term = Term(find_effect("end_stop"), {"gap": 0.01})
    names = [p.name for p in find_effect("end_stop").parameters]
    assert [p.name for p in term.free] == [n for n in names if n != "gap"]


def test_a_sensors_fault_is_no_part_of_the_equation_of_motion():
    model = base_model()
    assert model.plus(Term(find_effect("clipping"), {"channel": "acceleration"})).equation == model.equation
