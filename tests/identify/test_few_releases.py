"""Two of many releases are searched for several effects; all of them judge."""

import numpy as np
import pytest
from releases import drawn
from specimens import among

from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.free_decay import FreeDecay
from identify.judging.several_effects import FewReleases
from identify.judging.suspects import singles
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import BESIDE_OTHERS, prepare
from mocks.generate import draw

RIG = {"stiffness": 614.0, "mu_0": 0.13, "mu_1": 0.28, "rate": 256.0}
SPRING = {"cubic_stiffness": {"k3": 9000.0}}
PAIR = SPRING | {"quadratic_damping": {"c2": 0.8}}
RIVALS = tuple(map(find_effect, (*PAIR, "quintic_stiffness", "cubic_damping", "freeplay", "hysteresis")))
AMPLITUDES = (0.012, 0.024, 0.006, 0.018)


def several(hidden, parameters, seconds=2.5, amplitudes=AMPLITUDES):
    return tuple(
        drawn(hidden, 0.02, 910 + i, amplitude=a, seconds=seconds, parameters=parameters, **RIG)[0]
        for i, a in enumerate(amplitudes)
    )


def test_the_largest_and_the_smallest_amplitude_are_searched_and_all_are_fitted_to_what_is_found():
    decays = several("cubic_stiffness", SPRING)
    whole = fit_baseline(decays, base_model())
    library = (find_effect("cubic_stiffness"), find_effect("clipping"))
    (cubic,) = (one for one in singles(whole, library) if one.name == "cubic_stiffness")
    few = FewReleases.of(whole)
    assert few.places == (1, 2)
    assert len(few.baseline.fit.windows) == 2
    alone = few.on_few(cubic.fit)
    assert len(alone.windows) == 2
    again = few.on_all(alone)
    k3 = again.values["cubic_stiffness.k3"]
    assert abs(k3.value - 9000.0) < 5.0 * k3.std
    assert again.reduced < 1.1
    assert len(again.windows) == len(decays)


def test_six_releases_of_three_cycles_each_name_together_what_none_can_alone():
    fixed = RIG | {"mu_0": 0.05, "parameters": {"quadratic_damping": {"c2": 3.0}}}
    decays = []
    for i in range(6):
        made = draw("quadratic_damping", 0.05, 910 + i, amplitude=0.03 * 0.8**i, **fixed)
        kept = slice(round((0.8 + 0.85) * made.rate))
        decay = FreeDecay(made.rate, displacement=made.displacement[kept])
        decays.append(prepare(decay, fewest_cycles=BESIDE_OTHERS))
        with pytest.raises(NotIdentifiable, match="at least four"):
            prepare(decay)
    library = among("quadratic_damping", "position_dependent_damping", "cubic_stiffness", "hysteresis")
    assert diagnose(decays, library=library).named == ("quadratic_damping",)
    assert diagnose(decays[0], library=library).verdict == "not_enough_data"


def test_of_two_releases_both_are_searched():
    decays = several("cubic_stiffness", SPRING, amplitudes=(0.02, 0.01))
    whole = fit_baseline(decays, base_model())
    few = FewReleases.of(whole)
    assert few.baseline is whole
    assert few.on_few(whole.fit) is whole.fit
    assert few.on_all(whole.fit) is whole.fit


@pytest.mark.slow
def test_two_effects_in_four_releases_are_named():
    found = diagnose(several("cubic_stiffness+quadratic_damping", PAIR, seconds=3.0), library=RIVALS)
    assert set(found.named) == set(PAIR)
    assert len(found.final.windows) == len(AMPLITUDES)


@pytest.mark.slow
def test_what_two_releases_show_and_all_do_not_is_not_named():
    decays = list(several("cubic_stiffness+quadratic_damping", PAIR, seconds=3.0))
    other = {"cubic_stiffness": {"k3": -9000.0}, "quadratic_damping": {"c2": 3.0}}
    decays[0] = several("cubic_stiffness+quadratic_damping", other, seconds=3.0)[0]
    found = diagnose(decays, library=RIVALS)
    assert found.verdict == "unknown_effect"
    assert np.isfinite(found.final.chi_square)
