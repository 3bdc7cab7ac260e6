"""One rig with other springs, dampers or masses: what was changed is each release's own, and the rest one law."""

import numpy as np
import pytest
from specimens import among

from identify.diagnosis.diagnose import diagnose
from identify.fitting.baseline import fit_baseline
from identify.fitting.own_linear import changed_on_purpose
from identify.fitting.prediction import predict
from identify.free_decay import FreeDecay
from identify.judging.releases_differ import release_values
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

STIFFNESS, FRICTION, DAMPING, DRAG = 614.0, 0.1, 0.28, 0.8
AMPLITUDES = (0.025, 0.018, 0.013)
RIVALS = among("quadratic_damping", "position_dependent_damping", "hysteresis", "cubic_stiffness")


def rig(springs, lighter=(1.0, 1.0, 1.0), drag=DRAG, *, both=True):
    """Return releases with a spring each and their masses `lighter` by a factor: all forces per mass grow by it."""
    decays = []
    for i, (spring, light, amplitude) in enumerate(zip(springs, lighter, AMPLITUDES, strict=False)):
        own = {"stiffness": spring * light, "mu_0": FRICTION * light, "mu_1": DAMPING * light}
        hidden = {"parameters": {"quadratic_damping": {"c2": drag * light}}} if drag else {}
        sample = draw(
            "quadratic_damping" if drag else None,
            0.02,
            700 + i,
            amplitude=amplitude,
            rate=256.0,
            seconds=5.0,
            **own,
            **hidden,
        )
        u, a = sample.displacement, sample.acceleration if both else None
        decays.append(prepare(FreeDecay(sample.rate, displacement=u, acceleration=a)))
    return tuple(decays)


def test_of_three_springs_each_is_found_and_the_friction_is_one():
    springs = (STIFFNESS, 2.5 * STIFFNESS, 0.4 * STIFFNESS)
    decays = changed_on_purpose(rig(springs, drag=0.0), frozenset({"stiffness"}))
    found = fit_baseline(decays, base_model())
    own = {one.index: one.value for one in release_values(found.fit) if "stiffness" in one.parameter}
    for i, spring in enumerate(springs):
        assert abs(own[i].value - spring) < 5.0 * own[i].std
        assert own[i].std < 1e-3 * spring
    friction = found.fit.parameters["coulomb_friction.mu_0"]
    assert abs(friction.value - FRICTION) < 5.0 * friction.std
    assert found.at_floor


def test_without_saying_so_no_common_model_follows_three_springs():
    decays = rig((STIFFNESS, 2.5 * STIFFNESS, 0.4 * STIFFNESS), drag=0.0)
    assert fit_baseline(decays, base_model()).fit.reduced > 100.0


@pytest.mark.parametrize("both", [True, False], ids=["two channels", "displacement alone"])
def test_drag_is_named_on_three_springs_together(both):
    decays = rig((STIFFNESS, 2.0 * STIFFNESS, 0.5 * STIFFNESS), both=both)
    found = diagnose(changed_on_purpose(decays, frozenset({"stiffness"})), library=RIVALS)
    assert found.named == ("quadratic_damping",)
    c2 = found.final.parameters["quadratic_damping.c2"]
    assert abs(c2.value - DRAG) < 5.0 * c2.std
    assert c2.std < 0.02 * DRAG


def test_three_masses_on_one_spring_share_forces_that_are_each_over_its_own_mass():
    lighter = (1.0, 1.6, 0.6)
    decays = changed_on_purpose(rig((STIFFNESS,) * 3, lighter), frozenset({"inertia"}))
    ratios = np.array([decay.window.lightness for decay in decays])
    assert ratios / ratios[0] == pytest.approx(lighter, rel=2e-3)
    found = diagnose(decays, library=RIVALS)
    assert found.named == ("quadratic_damping",)
    c2 = found.final.parameters["quadratic_damping.c2"]
    assert (
        abs(c2.value - DRAG) < 0.01 * DRAG
    )  # the ratio of the masses is that of the squared frequencies, to 2e-3


def test_what_two_springs_show_predicts_a_third_that_is_said_to_be_another():
    first, second, third = rig((STIFFNESS, 2.0 * STIFFNESS, 0.5 * STIFFNESS))
    varies = frozenset({"stiffness"})
    law = diagnose(changed_on_purpose((first, second), varies), library=RIVALS).final
    (other,) = changed_on_purpose((third,), varies)
    assert predict(law.model, law.parameters, other).motion_percent < 1.0
    assert predict(law.model, law.parameters, third).motion_percent > 50.0
