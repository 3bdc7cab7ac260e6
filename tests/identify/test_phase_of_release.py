"""Shaking from outside has one frequency and size, and another phase in each release."""

import numpy as np
import pytest
from specimens import among

from identify import FreeDecay, base_model
from identify.comparison.compare import compare_fitted
from identify.diagnosis.diagnose import diagnose
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.prediction import predict
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw

RIVALS = among("harmonic_forcing", "mains_hum", "cubic_stiffness", "end_stop")
SHAKEN = {"amp": 0.1, "f": 12.1}
BENCH = {"linear_stiffness.k": 620.0, "coulomb_friction.mu_0": 0.02, "viscous_damping.mu_1": 0.3}


def shaken(seed: int, amplitude: float, phase: float) -> PreparedDecay:
    bench = {"stiffness": 620.0, "mu_0": 0.02, "mu_1": 0.3, "lag": 0.001}
    sample = draw(
        "harmonic_forcing",
        0.02,
        seed,
        amplitude=amplitude,
        parameters={"harmonic_forcing": SHAKEN | {"phase": phase}},
        **bench,
    )
    return prepare(FreeDecay(sample.rate, sample.displacement, sample.acceleration))


@pytest.mark.parametrize("two_channels", [True, False])
def test_releases_that_are_shaken_in_other_phases_have_one_law(two_channels: bool):
    phases = (0.4, 2.9, 5.1)
    decays = tuple(
        shaken(seed, size, phase)
        for seed, size, phase in zip((1, 2, 3), (0.02, 0.015, 0.01), phases, strict=True)
    )
    if not two_channels:
        decays = tuple(
            prepare(FreeDecay(one.window.rate, one.window.readings["displacement"])) for one in decays
        )
    found = diagnose(decays[:2], library=RIVALS)
    assert found.named == ("harmonic_forcing",)
    top = found.suspects[0]
    for name, truth in SHAKEN.items():
        value = top.fit.of(top.term)[name]
        assert abs(value.value - truth) < 5.0 * value.std
    seen = [top.fit.of(top.term)[f"phase[{i}]"].value for i in range(2)]
    apart = (seen[1] - seen[0]) - (phases[1] - phases[0])
    reading = (
        2.0 * np.pi * SHAKEN["f"] / decays[0].window.rate
    )  # when it was let go is known to a reading or two
    assert abs(np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi) < 2.0 * reading
    law = {name: value.value for name, value in top.fit.parameters.items() if "[" not in name}
    model = base_model().plus(Term(find_effect("harmonic_forcing")))
    assert predict(model, law, decays[2], hold=True).chi_square < 1.3


def test_the_pieces_of_a_long_release_share_its_phase():
    hidden = {"harmonic_forcing": SHAKEN | {"phase": 2.8}}
    sample = draw("harmonic_forcing", 0.02, 11, seconds=25.0, mu_0=0.002, mu_1=0.1, parameters=hidden)
    found = diagnose(FreeDecay(sample.rate, sample.displacement, sample.acceleration), library=RIVALS)
    assert found.named == ("harmonic_forcing",)
    top = found.suspects[0]
    assert len(top.fit.windows) > 1
    assert set(top.fit.of(top.term)) == {"amp", "f", "phase"}


def test_a_model_that_is_shaken_as_the_mass_fails_nowhere():
    decay = shaken(1, 0.02, 0.4)
    model = base_model().plus(Term(find_effect("harmonic_forcing")))
    start = predict(
        model, {f"harmonic_forcing.{name}": value for name, value in SHAKEN.items()} | BENCH, decay
    )
    assert not compare_fitted(fit_baseline((decay,), model, start.values)).places
