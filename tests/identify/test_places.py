from types import SimpleNamespace

import numpy as np
import pytest
from releases import drawn, ready

from identify.diagnosis import null_distribution as chance_module
from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.null_distribution import null_distribution
from identify.diagnosis.null_forces import _of_each
from identify.diagnosis.places import Places
from identify.diagnosis.suspects import try_terms
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.initial_values import reachable_starts
from identify.model.model import Term, base_model
from mocks.generate import draw

SOMEWHERE = tuple({"gap": float(i)} for i in range(6))


def test_likeliest_are_the_places_that_lower_chi_square_more_than_their_neighbours():
    drops = np.array([[3.0, 0.0], [1.0, 0.0], [2.0, 1.0], [4.0, 2.0], [0.0, 3.0], [0.5, 4.0]])
    places = Places(SOMEWHERE, drops)
    assert [place["gap"] for place in places.likeliest(0)] == [3.0, 0.0, 5.0]
    assert [place["gap"] for place in places.likeliest(1)] == [5.0]
    assert list(places.best) == [4.0, 4.0]


def test_where_nothing_is_gained_no_place_is_likely():
    assert Places(SOMEWHERE, np.zeros((6, 1))).likeliest(0) == ()


def test_between_two_places_chance_gains_what_lies_there():
    """Tones that begin at the release, 2.2 radians apart over the record: one between them is common to both by 0.81."""
    time = np.linspace(0.0, 1.0, 2000)
    tones = [np.cos(omega * time) for omega in (60.0, 61.1, 62.2)]
    unit = [tone / np.linalg.norm(tone) for tone in tones]
    nothing_known = SimpleNamespace(free=lambda columns: columns)
    drops = np.zeros((2, 1))
    noise = 5.0 * unit[1][:, None]
    _of_each({0: [tones[0]], 1: [tones[2]]}, nothing_known, noise, drops, one_sided=True)
    assert float(unit[0] @ unit[1]) == pytest.approx(np.sin(1.1) / 1.1, abs=0.02)
    # of the 25 that the tone itself gains, either neighbour has 0.81^2 and their mean 2 0.81^2 / (1 + sin(2.2) / 2.2)
    assert drops.max() == pytest.approx(25.0 * 0.95, abs=0.5)


@pytest.mark.parametrize("seed", [7400, 7401, 7402])
@pytest.mark.parametrize("name", ["freeplay", "hysteresis", "stribeck_friction", "harmonic_forcing"])
def test_a_fit_finds_what_the_same_noise_would_have_gained_as_a_draw_of_chance(name, seed, monkeypatch):
    prepared, _ = drawn(None, 0.0, seed, seconds=4.0)
    base = fit_baseline((prepared,), base_model()).fit
    term, gains = Term(find_effect(name)), []

    def seen(*given):
        places = whole(*given)
        gains.append(float(places.best[-1]))
        return places

    whole = chance_module.force_places
    monkeypatch.setattr(chance_module, "force_places", seen)
    chance = null_distribution((prepared,), base, (term,), draws=100)
    (found,) = try_terms((prepared,), base, (term,), likeliest=chance.likeliest)
    # strengths that noise allows move the readings in proportion, and an inner parameter that is free finds a little more
    assert found.gain > 0.95 * max(gains) - 0.1


def test_a_line_of_a_force_begins_at_the_frequency_of_the_highest_peak():
    prepared, truth = drawn("harmonic_forcing", 0.0003, 7403, seconds=6.0)
    base = fit_baseline((prepared,), base_model()).fit
    term = Term(find_effect("harmonic_forcing"))
    chance = null_distribution((prepared,), base, (term,), draws=100)
    hidden = truth["parameters"]["f"]
    assert chance.likeliest[term.variant][0]["f"] == pytest.approx(hidden, abs=0.1)


def test_only_what_has_a_choice_of_places_has_likeliest_ones():
    prepared, _ = drawn(None, 0.0, 7404, seconds=3.0)
    base = fit_baseline((prepared,), base_model()).fit
    terms = (Term(find_effect("cubic_stiffness")), Term(find_effect("freeplay")))
    likeliest = null_distribution((prepared,), base, terms, draws=100).likeliest
    assert terms[0].variant not in likeliest
    gaps = {
        place["gap"] for place in reachable_starts(terms[1], SimpleNamespace(amplitude=prepared.amplitude))
    }
    assert {place["gap"] for place in likeliest[terms[1].variant]} <= gaps


def test_a_library_of_nothing_claims_nothing():
    sample = draw("cubic_stiffness", 0.03, 5)
    decay = ready(sample.rate, sample.displacement, sample.acceleration)
    assert diagnose((decay,), library=()).verdict == "unknown_effect"
    sample = draw(None, 0.0, 5)
    decay = ready(sample.rate, sample.displacement, sample.acceleration)
    assert diagnose((decay,), library=()).verdict == "nothing_missing"


@pytest.mark.slow
def test_a_second_mass_is_fitted_from_mid_decay_with_hum_beside_it():
    sample = draw("second_mass", 0.03, 60600, imperfections=("hum",))
    first = round(1.7 * sample.rate)
    found = diagnose((ready(sample.rate, sample.displacement[first:], sample.acceleration[first:]),))
    second = next(s for s in found.suspects if s.effect.name == "second_mass")
    assert second.parameters["ratio"].value == pytest.approx(sample.truth["parameters"]["ratio"], rel=0.2)
    assert second.parameters["w2"].value == pytest.approx(sample.truth["parameters"]["w2"], rel=0.01)
