"""The voltages that a released mass puts on two pins: the double's physics, a potentiometer and an ADXL335."""

from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from mocks.testbed import Bench, Release, simulate_channels

FILE_HZ = 16384.0
REST_S = 4.0
MOTION_S = 9.0
RELEASED_AT_M = 0.020
BENCH = Bench()

# As in rig.h: 50 mm across 3.3 V, 330 mV per g, both around the middle of the supply.
SUPPLY_V = 3.3
V_PER_M = 1 / 0.015152
V_PER_M_S2 = 0.330 / 9.80665
# The ADXL335's output resistor (32 kOhm) and its capacitor (0.1 uF).
ACCELEROMETER_RC_S = 3.2e-3


def volts(rest_s: float = REST_S, motion_s: float = MOTION_S) -> np.ndarray:
    """Volts at both pins, (times, 2) at FILE_HZ: at rest, let go from RELEASED_AT_M, free."""
    time = np.arange(int((rest_s + motion_s) * FILE_HZ)) / FILE_HZ - rest_s
    x, a = simulate_channels(BENCH, Release(displacement=RELEASED_AT_M), time, time)
    share = -np.expm1(-1 / (FILE_HZ * ACCELEROMETER_RC_S))
    behind_rc = lfilter([share], [1, share - 1], a)
    return np.stack([SUPPLY_V / 2 + x * V_PER_M, SUPPLY_V / 2 + behind_rc * V_PER_M_S2], axis=1)


def write_volts(path: Path, **length: float) -> Path:
    """Write them as pairs of 32-bit floats."""
    volts(**length).astype("<f4").tofile(path)
    return path


# As on the LaunchPad: eight readings of 12 bits a trigger, each the mean of 16 taken at a million a second.
ORDER = np.array([0, 1, 1, 0, 0, 1, 1, 0])
READING_S = 16e-6


def readings(rate_hz: float, noise_mv: float, seed: int, **length: float) -> np.ndarray:
    """What the converter reads at each trigger, (triggers, 8) of 12 bits."""
    at_pins = volts(**length)
    time = np.arange(len(at_pins)) / FILE_HZ
    triggers = np.arange(int(time[-1] * rate_hz) - 1) / rate_hz
    when = triggers[:, None] + READING_S * np.arange(8)
    seen = np.where(ORDER == 0, np.interp(when, time, at_pins[:, 0]), np.interp(when, time, at_pins[:, 1]))
    seen += np.random.default_rng(seed).normal(0, 1e-3 * noise_mv, seen.shape)
    return np.clip(seen / SUPPLY_V * 4096, 0, 4095).astype("<u2")
