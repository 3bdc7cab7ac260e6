"""Draw the parameters of bench, release and sensors: off every grid, and different from seed to seed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocks.sensors import Sensor
from mocks.testbed import Bench, Release


@dataclass(frozen=True)
class BenchParameters:
    """What is drawn for one recording, SI units; `lag` is how late the displacement is.

    `sensor_pair` draws which sensor strays and which lines are picked up, where there are imperfections: several recordings
    with one number have one pair of sensors. None: that of the recording's own seed.
    """

    stiffness: float
    mu_0: float
    mu_1: float
    amplitude: float
    lag: float
    release_time: float
    released_at: float
    offset_displacement: float
    offset_acceleration: float
    noise_displacement: float
    noise_acceleration: float
    velocity: float = 0.0
    gain_error: float = 0.0
    rate: float = 256.0
    seconds: float = 8.0
    rest: float = 0.75
    bits: int = 16
    range_displacement: float = 0.05
    range_acceleration: float = 50.0
    imperfections: tuple[str, ...] = ()
    sensor_pair: int | None = None

    @property
    def bench(self) -> Bench:
        """The bench with nothing hidden in it."""
        return Bench(self.stiffness, self.mu_0, self.mu_1)

    @property
    def release(self) -> Release:
        """How the mass is let go."""
        return Release(self.amplitude, self.velocity, self.release_time)

    @property
    def sensors(self) -> dict[str, Sensor]:
        """Both channels by name; the accelerometer carries the gain error."""
        return {
            "displacement": Sensor(
                self.noise_displacement,
                self.bits,
                self.range_displacement,
                1.0,
                self.offset_displacement,
                self.lag,
            ),
            "acceleration": Sensor(
                self.noise_acceleration,
                self.bits,
                self.range_acceleration,
                1.0 + self.gain_error,
                self.offset_acceleration,
            ),
        }


def draw_parameters(seed: int, fixed: dict[str, Any]) -> BenchParameters:
    """Return the parameters of `seed` with the values of `fixed` in place of drawn ones.

    TypeError names what is no parameter.
    """
    known = [field.name for field in dataclasses.fields(BenchParameters)]
    unknown = sorted(set(fixed) - set(known))
    if unknown:
        raise TypeError(f"a bench has no {', '.join(unknown)}; it has {', '.join(known)}")
    random = np.random.default_rng([seed, 1])
    rest = float(fixed.get("rest", 0.75))
    rate = float(fixed.get("rate", 256.0))
    side = -1.0 if random.random() < 0.5 else 1.0
    drawn = BenchParameters(
        stiffness=614.0 * (1.0 + random.uniform(-0.01, 0.01)),
        mu_0=random.uniform(0.10, 0.15),
        mu_1=random.uniform(0.25, 0.30),
        amplitude=side * random.uniform(0.015, 0.025),
        lag=random.uniform(-3e-3, 3e-3),
        release_time=draw_release_time(random),
        released_at=rest + random.random() / rate,
        offset_displacement=random.uniform(-2e-4, 2e-4),
        offset_acceleration=random.uniform(-0.05, 0.05),
        noise_displacement=random.uniform(3e-6, 8e-6),
        noise_acceleration=random.uniform(0.005, 0.015),
    )
    return dataclasses.replace(drawn, **fixed)


def draw_release_time(random: np.random.Generator) -> float:
    """Return how long letting go takes, s: no time in one half of the cases, else 2-12 ms."""
    return float(random.random() < 0.5) * random.uniform(0.002, 0.012)
