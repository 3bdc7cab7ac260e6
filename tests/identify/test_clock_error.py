"""The error of the recorder's clock in what is identified: scaling of time is the truth here."""

from math import pi

import numpy as np
import pytest
from decays_in_closed_form import exponential

from identify.clock_error import clock_limits, seconds_in, with_clock
from identify.effects.library import LIBRARY
from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare
from identify.preprocessing.sampling import average_blocks
from identify.restoring_force.restoring_force import identify_restoring_force
from identify.wavelet.wavelet import identify_wavelet

RATE, FREQUENCY, DECAY = 256.0, 4.0, 0.14
STIFFNESS = (2 * pi * FREQUENCY) ** 2 + DECAY**2  # w0^2 of A e^(-d t) cos(w t), 1/s^2
OFF = 500e-6  # share by which the clock is fast


def recorded(rate_std: float | None) -> FreeDecay:
    """A decay whose board says 256 Hz and samples 500 ppm faster."""
    time = np.arange(2048) / (RATE * (1 + OFF))
    u, _, a = exponential(time, FREQUENCY, decay=DECAY)
    noise = np.random.default_rng(5).standard_normal((2, len(time)))
    return FreeDecay(
        RATE,
        displacement=u + 5e-6 * noise[0],
        acceleration=a + 0.01 * noise[1],
        release=0,
        noise_displacement=5e-6,
        noise_acceleration=0.01,
        rate_std=rate_std,
    )


@pytest.mark.parametrize(
    ("unit", "power"),
    [
        ("N/m", -2), ("1/s^2", -2), ("m/s^2", -2), ("1/s", -1), ("1/m", 0), ("s/m^2", 1), ("1/(m^2 s)", -1),
        ("1/(s^2 m^2)", -2), ("Hz", -1), ("s", 1), ("1", 0), ("N m/rad", -2), ("N s/m", -1), ("rad/s", -1), ("us", 0),
    ],
)  # fmt: skip
def test_the_second_is_found_in_a_unit(unit: str, power: int) -> None:
    assert seconds_in(unit) == power


def test_every_unit_of_the_library_is_understood() -> None:
    known = {"m", "s", "rad", "Hz", "N", "reading", ""}
    for effect in LIBRARY:
        for parameter in effect.parameters:
            letters = "".join(c if c.isalpha() else " " for c in parameter.unit).split()
            assert set(letters) <= known, parameter


def test_the_error_grows_with_the_power_of_the_second() -> None:
    value = Estimate(631.0, 0.01, "1/s^2")
    assert with_clock(value, RATE, None) == value
    with_it = with_clock(value, RATE, 0.128)
    assert with_it.std == pytest.approx(np.hypot(0.01, 2 * 500e-6 * 631.0))
    assert clock_limits(with_it, RATE, 0.128)
    assert not clock_limits(with_clock(value, RATE, 1e-9), RATE, 1e-9)


def test_a_stiffness_from_a_wrong_clock_is_within_its_error_and_the_clock_is_named() -> None:
    believed = identify_wavelet(recorded(None))
    assert abs(believed.stiffness.value - STIFFNESS) > 20 * believed.stiffness.std
    assert believed.clock == ""
    found = [method(recorded(OFF * RATE)) for method in (identify_wavelet, identify_restoring_force)]
    for known in found:
        assert abs(known.stiffness.value - STIFFNESS) < 2 * known.stiffness.std
        assert known.stiffness.std == pytest.approx(2 * OFF * STIFFNESS, rel=0.02)
    assert "clock limits the stiffness: its rate is known to 500 ppm" in found[0].clock


def test_the_clocks_error_reaches_the_window_of_a_fit_and_survives_averaging() -> None:
    assert prepare(recorded(0.128)).window.rate_std == pytest.approx(0.128)
    assert prepare(recorded(0.128)).window.part(slice(0, None, 4)).rate_std == pytest.approx(0.032)
    assert average_blocks(recorded(0.128), 4, 3.9)[0].rate_std == pytest.approx(0.032)
