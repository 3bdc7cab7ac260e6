"""A second mass is named by a line of its own, not by a harmonic of the motion."""

import numpy as np
import pytest
from specimens import among, diagnosed

from identify.diagnosis.diagnose import diagnose
from identify.effects.effect import Scales
from identify.effects.memory import SECOND_MASS
from identify.free_decay import FreeDecay
from mocks.generate import draw


def scales(duration: float) -> Scales:
    """Sizes of a motion of 1 Hz."""
    return Scales(1.0, 2 * np.pi, duration, 60.0, {"displacement": 1.0}, {})


def test_a_tuned_second_mass_shows_by_its_beats() -> None:
    tuned = {"w2": 2 * np.pi * 1.05, "zeta": 0.02}
    assert SECOND_MASS.plausible({"ratio": 0.07, **tuned}, scales(8.0))
    assert not SECOND_MASS.plausible({"ratio": 0.07, **tuned}, scales(1.5))  # less than half a beat
    assert SECOND_MASS.plausible(
        {"ratio": 0.0, **tuned}, scales(12.0)
    )  # another line, however weakly coupled
    assert not SECOND_MASS.plausible({"ratio": 0.0, **tuned}, scales(8.0))  # the motion itself
    assert not SECOND_MASS.plausible(
        {"ratio": 0.07, **tuned, "zeta": 0.4}, scales(8.0)
    )  # no line is left to beat


@pytest.mark.parametrize(("line", "zeta", "plausible"), [
    (2.0, 0.001, False),  # the second harmonic
    (3.0, 0.0, False),
    (2.0, 0.05, True),  # dies long before a harmonic would
    (2.3, 0.001, True),
    (1.5, 0.001, True),
])  # fmt: skip
def test_a_lasting_line_on_a_harmonic_is_no_second_mass(line: float, zeta: float, plausible: bool) -> None:
    values = {"ratio": 0.01, "w2": 2 * np.pi * line, "zeta": zeta}
    assert SECOND_MASS.plausible(values, scales(8.0)) is plausible


@pytest.mark.parametrize("phase", [1.5, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_camera_s_second_harmonic_is_not_called_a_second_mass(phase: float) -> None:
    """A pendulum filmed for eight cycles in half pixels, whose picture bends by 1.5 %."""
    time, random = np.arange(474) / 60.0, np.random.default_rng(3)
    w = 2 * np.pi * 0.992
    reading = 44.9 * np.exp(-0.033 * time) * np.cos(w * time + 0.1) + 0.69 * np.cos(2 * w * time + phase)
    reading = np.round(2.0 * (reading + 0.2 * random.standard_normal(len(time)))) / 2.0
    found = diagnosed(FreeDecay(60.0, displacement=1e-3 * reading), also="second_mass")
    assert found.verdict == "unknown_effect"
    assert not found.named


@pytest.mark.parametrize(
    ("hidden", "strength", "seed"), [("second_mass", 0.1, 55142), ("harmonic_forcing", 0.1, 71002)]
)
def test_what_swings_by_itself_is_named_though_the_record_begins_in_mid_decay(
    hidden: str, strength: float, seed: int
) -> None:
    """One channel without a rest: how far the second mass was from equilibrium at the start is not known."""
    sample = draw(hidden, strength, seed)
    found = diagnose(
        FreeDecay(sample.rate, sample.displacement[round(1.2 * sample.rate) :]),
        library=among("second_mass", "harmonic_forcing", "mains_hum", "cubic_stiffness", "end_stop"),
    )
    assert found.named == (hidden,)
    if hidden == "second_mass":
        ratio = found.suspects[0].parameters["ratio"].value
        assert ratio == pytest.approx(sample.truth["parameters"]["ratio"], rel=0.1)


def test_two_pendulums_joined_by_a_spring_are_a_second_mass() -> None:
    """Two modes 3 % apart for most of a beat: the ratio of masses cannot be known, that something swings beside it can."""
    time, random = np.arange(144) / 4.0, np.random.default_rng(5)
    first, second = np.exp(-0.012 * time) * np.cos(4.44 * time), np.exp(-0.013 * time) * np.cos(4.59 * time)
    u = 0.1 * (first + 0.8 * second)
    found = diagnose(
        FreeDecay(4.0, displacement=u + 3e-4 * random.standard_normal(len(time))),
        library=among("second_mass", "harmonic_forcing", "mains_hum", "fading_damping", "fading_friction"),
    )
    assert found.named == ("second_mass",)
    assert not found.suspects[0].strength_known
