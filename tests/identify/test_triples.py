import pytest
from releases import drawn
from specimens import diagnosed

from identify.effects.library import LIBRARY
from identify.fitting.initial_values import scales_of
from identify.judging.search import promising_sets
from identify.judging.suspects import candidate_terms
from identify.model.model import base_model

THREE = "hysteresis+cubic_stiffness+quadratic_damping"


def screened(hidden, seed=71):
    prepared = drawn(hidden, 0.02, seed, amplitude=0.02)[0]
    terms = candidate_terms(base_model(), LIBRARY, prepared.window)
    return promising_sets(prepared, base_model(), terms, scales_of(prepared, {}))[1]


def test_three_effects_lead_the_screening_though_pairs_of_them_do_not():
    assert {begun.name for begun in screened(THREE)[0]} == set(THREE.split("+"))


@pytest.mark.slow
def test_three_effects_at_once_are_named_and_nothing_else():
    found = diagnosed(drawn(THREE, 0.02, 71, amplitude=0.02)[0])
    assert set(found.named) == set(THREE.split("+"))


@pytest.mark.slow
def test_a_line_among_three_begins_in_the_right_half_of_its_cycle():
    """Its amplitude is not negative: begun half a cycle off it is none, and a fit finds no way back."""
    three = "end_stop+cubic_damping+harmonic_forcing"
    assert set(diagnosed(drawn(three, 0.02, 60702)[0], also="cubic_damping").named) == set(three.split("+"))
