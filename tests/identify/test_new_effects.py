"""Effects of real rigs: simulated as the testbed's double does, and named where they are hidden."""

import numpy as np
import pytest
from releases import drawn, ready

from identify.diagnosis.diagnose import diagnose
from identify.effects.families import FAMILIES
from identify.effects.library import LIBRARY, find_effect
from identify.fitting.parameter_layout import ParameterLayout
from identify.model.model import Term, base_model
from identify.model.simulate import make_system, simulate, substeps_for
from mocks import testbed
from mocks.forces import Effect
from mocks.generate import draw

W0, RATE, SAMPLES = np.sqrt(614.0), 256.0, 2048
ALL = (*LIBRARY, *(family.effect for family in FAMILIES))

CASES = {
    "signed_quadratic_stiffness": {"k2a": 700.0},
    "settling_stiffness": {"r": 0.02, "tau": 2.0},
    "fading_friction": {"dmu": 0.08, "tau": 2.0},
    "fading_damping": {"c": 0.2, "tau": 2.0},
    "impact_with_loss": {"ks": 80.0, "gap": 0.01, "side": -1.0, "loss": 1.5},
    "dahl_friction": {"kd": 60.0, "ud": 0.001},
    "power_law_stiffness": {"f": 0.3, "p": 1.5, "at": 0.02},
    "power_law_damping": {"f": 0.1, "p": 0.5, "at": 0.5},
    "bouc_wen_hysteresis": {"kh": 20.0, "uy": 0.004, "n": 0.8},
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("mu_0", [0.0, 0.13])
def test_the_motion_is_that_of_the_double(name, mu_0):
    effect, values = find_effect(name, ALL), CASES[name]
    start = 5e-4 if effect.states else 0.0
    system = make_system((effect,))
    found = simulate(
        system,
        np.array([614.0, 0.277, mu_0]),
        np.array([effect.table(values, {"linear_stiffness.k": 614.0})]),
        start=(0.02, 0.0),
        states=np.array(
            [[start / values.get("ud", values.get("uy", 1.0)), 0.0]]
        ),  # a share of what it gives way at
        samples=SAMPLES,
        rate=RATE,
        substeps=substeps_for(W0, RATE, nonsmooth=system.nonsmooth),
    )
    hidden = Effect(name, values | ({"z_start": start} if effect.states else {}))
    bench = testbed.Bench(614.0, mu_0, 0.277, (hidden,))
    true = testbed.simulate(bench, testbed.Release(0.02), np.arange(SAMPLES) / RATE)
    # A step of 0.055 rad loses 6e-8 m in 8 s; a kink within a step, or a power below 1 at a reversal, as much again.
    assert np.max(np.abs(found.displacement - true.displacement)) < 2e-7


@pytest.mark.slow
@pytest.mark.parametrize("name", ["settling_stiffness", "impact_with_loss"])  # the bench hides each effect
def test_an_effect_of_real_rigs_is_named_first(name):
    prepared, truth = drawn(name, 0.01, seed=9200)
    found = diagnose((prepared,))
    assert found.named == (name,)
    strongest = found.suspects[0].effect.strength.name
    estimate = found.suspects[0].parameters[strongest]
    assert abs(estimate.value - truth["parameters"][strongest]) < 4.5 * estimate.std


@pytest.mark.parametrize("name", ["dahl_friction", "bouc_wen_hysteresis", "hysteresis"])
def test_a_joint_holds_no_more_at_the_start_than_it_gives_way_at(name):
    """A fit that may begin with a state of metres makes a pulse of it, and gains by chance."""
    effect = find_effect(name, ALL)
    model = base_model().plus(Term(effect, {}))
    sample = draw(None, 0.0, 71039, seconds=3.0, rate=96.0)
    window = ready(sample.rate, sample.displacement, sample.acceleration).window
    states = [u for u in ParameterLayout(model, (window,), W0).unknowns if u.id.role == "state"]
    assert [(u.low, u.high) for u in states] == [(-effect.largest_state, effect.largest_state)]
    assert effect.states_at_rest(1.0, (20.0, 0.004, 1.0, 1.0, 0.0, 0.0))[0] == 1.0
    assert effect.states_at_rest(-0.001, (20.0, 0.004, 1.0, 1.0, 0.0, 0.0))[0] == pytest.approx(-0.25)
    assert (
        effect.states_at_rest(-0.001, (20.0, 0.0, 1.0, 1.0, 0.0, 0.0))[0] == 0.0
    )  # a parameter at its bound
