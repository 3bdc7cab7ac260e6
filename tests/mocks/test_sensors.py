"""Sensors and their faults."""

import math

import numpy as np
import pytest

from mocks import sensor_faults
from mocks.imperfections import BANDWIDTH, BEND, BENT, SLOW, distorted, noise_of, one_over_f
from mocks.sensors import Sensor, high_pass, hold_samples, quantise


def test_a_converter_rounds_to_its_step_and_stops_at_its_range():
    step = 0.1 / 2**16
    seen = quantise(np.array([0.0, 0.4 * step, 0.6 * step, 1.0, -1.0]), 16, 0.05)
    np.testing.assert_allclose(seen, [0.0, 0.0, step, 0.05 - step, -0.05], atol=1e-15)


def test_a_sensor_has_gain_offset_and_white_noise_of_the_rms_asked_for():
    sensor = Sensor(noise=0.01, full_scale=50.0, gain=1.02, offset=0.3)
    seen = sensor.convert(np.full(200_000, 2.0), np.random.default_rng(1))
    rms = math.hypot(0.01, sensor.step / math.sqrt(12.0))
    assert seen.mean() == pytest.approx(2.04 + 0.3, abs=4.0 * rms / math.sqrt(200_000))
    # The standard error of an rms from n values is 1 / sqrt(2 n): 0.16 %; four of these.
    assert seen.std() == pytest.approx(rms, rel=0.007)
    x = seen - seen.mean()
    assert abs(np.mean(x[1:] * x[:-1])) < 4.0 * rms**2 / math.sqrt(200_000)


def test_a_slow_sensor_is_late_and_small_as_a_first_order_filter_is():
    interval, corner = 1e-4, 9.0
    time = np.arange(60_000) * interval
    w, wc = 2.0 * math.pi * 4.0, 2.0 * math.pi * corner
    true = np.sin(w * time)
    wrong = sensor_faults.filter_error("sensor_bandwidth", corner, true, interval)[-300:]
    at = time[:: sensor_faults.OVERSAMPLING][-300:]
    expected = np.imag(wc / (1j * w + wc) * np.exp(1j * w * at)) - np.sin(w * at)
    np.testing.assert_allclose(wrong, expected, atol=(w * interval) ** 2)  # straight between samples


def test_a_sensor_that_bends_adds_its_square_and_its_cube():
    wrong = sensor_faults.error(
        "sensor_nonlinearity", {"quadratic": 2.0, "cubic": -3.0}, np.array([0.5, -0.5]), np.zeros(2)
    )
    np.testing.assert_allclose(wrong, [0.5 - 0.375, 0.5 + 0.375])


def test_a_coupling_capacitor_lets_a_step_decay_and_leads_a_sine():
    interval, corner = 1e-4, 0.3
    step = high_pass(np.ones(20000), interval, corner, 0.0)
    time = np.arange(20000) * interval
    np.testing.assert_allclose(step, np.exp(-2.0 * math.pi * corner * time), atol=1e-12)
    time = np.arange(600_000) * interval
    w, wc = 2.0 * math.pi * 4.0, 2.0 * math.pi * corner
    seen = high_pass(np.sin(w * time), interval, corner, 0.0)[-5000:]
    expected = np.imag(1j * w / (1j * w + wc) * np.exp(1j * w * time))[-5000:]
    np.testing.assert_allclose(seen, expected, atol=(w * interval) ** 2)  # straight between samples


def test_lost_samples_repeat_the_last_value_and_spend_the_energy_asked_for():
    signal = np.cos(np.arange(3000) / 10.0)
    energy = 0.01**2 * np.sum(signal**2)
    out, lost = hold_samples(signal, energy, 200, np.random.default_rng(3))
    assert 0.9 * energy < np.sum((out - signal) ** 2) <= 1.1 * energy
    assert lost
    assert lost[0][0] >= 200
    touched = np.zeros(3000, dtype=bool)
    for at, count in lost:
        assert np.all(out[at : at + count] == signal[at - 1])
        touched[at : at + count] = True
    assert np.all(out[~touched] == signal[~touched])


@pytest.mark.parametrize("name", sensor_faults.IMMEDIATE)
def test_a_fault_of_one_instant_has_the_strength_asked_for(name):
    time = np.arange(2240) / 256.0
    signal = np.exp(-0.2 * time) * np.cos(25.0 * time + 1.0)
    after = time > 0.75
    parameters = sensor_faults.size_of(name, 0.013, signal, time, after, np.random.default_rng(4), {})
    wrong = sensor_faults.error(name, parameters, signal, time)
    strength = sensor_faults.strength_of(name, wrong[after], signal[after])
    # Hum is sized by its rms over whole periods; 8 s are not whole ones: 1 in 2 pi 50 8 s.
    assert strength == pytest.approx(0.013, rel=1e-3)


def test_a_fault_that_needs_memory_is_refused_as_one_of_an_instant():
    with pytest.raises(ValueError, match="not a fault of one instant"):
        sensor_faults.error("dropouts", {}, np.zeros(3), np.zeros(3))


def test_noise_that_falls_as_one_over_f_has_unit_size_and_a_tenth_of_the_power_at_ten_times_the_frequency() -> (
    None
):
    noise = np.array([one_over_f(2048, np.random.default_rng(seed)) for seed in range(200)])
    assert np.mean(noise**2) == pytest.approx(1.0, rel=0.1)  # its slowest part varies most: 5 % by chance
    power = np.mean(np.abs(np.fft.rfft(noise * np.hanning(2048), axis=1)) ** 2, axis=0)
    assert np.mean(power[38:42]) / np.mean(power[380:420]) == pytest.approx(10.0, rel=0.15)


def test_an_imperfection_that_is_not_known_is_refused() -> None:
    with pytest.raises(ValueError, match="no imperfection is called ripple; there are: one_over_f"):
        noise_of(("ripple",), "displacement", 10, 0, ("displacement",))


def test_a_bent_sensor_is_wrong_by_its_share_at_the_peak() -> None:
    a = 10.0 * np.sin(np.linspace(0.0, 30.0, 4001))
    bent = distorted((BEND,), {"acceleration": a}, {}, 16)["acceleration"]
    assert np.max(np.abs(bent - a)) == pytest.approx(BENT * np.max(np.abs(a)), rel=1e-3)


def test_a_slow_sensor_lags_and_weakens_as_a_first_order_low_pass() -> None:
    f, over = 0.05, 16  # cycles a reading
    fine = np.sin(2.0 * np.pi * f * np.arange(16000) / over)
    slow = distorted((BANDWIDTH,), {"displacement": fine[::over]}, {"displacement": fine}, over)[
        "displacement"
    ]
    clock = np.arange(200, 1000)
    wave = 2.0 * np.mean(slow[clock] * np.exp(-2j * np.pi * f * clock)) * 1j
    assert wave == pytest.approx(1.0 / (1.0 + 1j * f / SLOW), abs=0.01)  # half a fine step: 2 pi 0.05 / 32
