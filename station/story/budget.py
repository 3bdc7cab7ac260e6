"""The uncertainty budget of a quoted value: readings and clock, calibration, mass, and their total (GUM)."""

import math
from dataclasses import dataclass

from daq.recording import Recording
from identify.clock_error import power_in
from station.story.engineering_values import EngineeringValue
from station.story.preparation import motion_channels


@dataclass(frozen=True)
class Budget:
    """Standard errors of one value, in its unit: of readings and clock, calibration, mass; None where not stated."""

    readings: float
    calibration: float | None
    mass: float | None

    @property
    def total(self) -> float | None:
        """The combined standard uncertainty (GUM); None where a part is not known."""
        if self.calibration is None or self.mass is None:
            return None
        return math.hypot(self.readings, self.calibration, self.mass)


def budget(
    one: EngineeringValue, calibration: float | None, mass_share: float | None, length: str = "m"
) -> Budget:
    """Split the error of a value into its parts.

    `calibration` is the relative uncertainty of the sensors' scale, `mass_share` that of the mass, None where not stated.
    The scale of the sensors enters a value by the power of `length` ("m" or "rad") in its unit per unit mass: not at all
    in a stiffness or a frequency, once in a friction force.
    """
    value, bare = one.value, one.per_mass
    readings: float = value.std
    mass: float | None = 0.0
    if bare is not None:
        readings = bare.std * abs(value.value / bare.value) if bare.value else bare.std
        mass = None if mass_share is None else abs(value.value) * mass_share
    power = abs(power_in((bare or value).unit, {length: 1}))
    scale = 0.0 if power == 0 else None if calibration is None else power * calibration * abs(value.value)
    return Budget(readings, scale, mass)


def calibration_of(recording: Recording, gain: float | None) -> float | None:
    """Return the relative uncertainty of the scale of the channels that are a motion; None where one has none stated.

    `gain` is that between two channels: they differ by what at least one of them is off.
    """
    stated = [channel.calibration_uncertainty for channel in motion_channels(recording).values()]
    if not stated or None in stated:
        return None
    off = 0.0 if gain is None else abs(gain - 1.0)
    return max(off, *(share for share in stated if share is not None))
