from dataclasses import replace

from releases import drawn
from specimens import among

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.estimate import Estimate
from identify.fitting.baseline import fit_baseline
from identify.judging.ranking import at_rest
from identify.judging.suspects import try_terms
from identify.model.model import Term, base_model
from identify.priors import RIVALS_WITHIN
from mocks.imperfections import ALIASED_LINE


def fitted_at(prepared, name, frequency):
    term = Term(find_effect(name), {"channel": "displacement"} if name == "mains_hum" else {})
    base = fit_baseline((prepared,), base_model()).fit
    found = try_terms((prepared,), base, (term,))[0]
    values = found.fit.values | {str(term.parameter("f")): Estimate(frequency, 0.01, "Hz")}
    return replace(found.fit, values=values), term


def test_a_line_that_a_sensor_shows_while_the_mass_is_held_is_no_forces():
    prepared, _ = drawn(None, 0.0, 1000, imperfections=(ALIASED_LINE,))
    lines = [line for colour in prepared.rest_colour.values() for line in colour.lines]
    strongest = max(lines, key=lambda line: line.power)
    assert (
        at_rest((prepared,), *fitted_at(prepared, "harmonic_forcing", strongest.frequency)) < -RIVALS_WITHIN
    )
    assert at_rest((prepared,), *fitted_at(prepared, "harmonic_forcing", strongest.frequency + 5.0)) == 0.0


def test_a_line_that_a_sensor_shows_while_the_mass_is_held_is_no_shaking_beside_a_force():
    prepared, _ = drawn("quadratic_damping", 0.003, 440, imperfections=(ALIASED_LINE,))
    rivals = ("harmonic_forcing", "position_dependent_damping", "hysteresis")
    found = diagnose(prepared, library=among("mains_hum", "quadratic_damping", *rivals))
    assert set(found.named) == {"mains_hum", "quadratic_damping"}
