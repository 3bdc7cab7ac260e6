"""The error that a recorder's clock brings into everything that holds a time: frequencies, stiffness, damping.

A clock whose rate is off by a share e stretches every time by it, so a value whose unit holds the second to the power
p is off by p e. All values of one record err together.
"""

from dataclasses import replace
from math import hypot

from identify.estimate import Estimate
from identify.units import power_in

_SECONDS = {"s": 1, "Hz": -1, "N": -2, "J": -2, "W": -3}


def seconds_in(unit: str) -> int:
    """Return the power of the second in a unit such as "N/m" (-2), "1/s", "s/m^2", "1/(m^2 s)" or "N s/m" (-1)."""
    return power_in(unit, _SECONDS)


def with_clock(value: Estimate, rate: float, rate_std: float | None) -> Estimate:
    """Return the value with the error of the rate (Hz, its standard error `rate_std`; None: unknown) in its own."""
    if not rate_std:
        return value
    return replace(value, std=hypot(value.std, _of_clock(value, rate, rate_std)))


def clock_limits(value: Estimate, rate: float, rate_std: float | None) -> bool:
    """Check whether most of the error of a value that went through `with_clock` is the clock's."""
    return bool(rate_std) and 2.0 * _of_clock(value, rate, rate_std or 0.0) ** 2 > value.std**2


def clock_sentence(stiffness: Estimate, rate: float, rate_std: float | None) -> str:
    """Warn where the clock limits a stiffness; "" where it does not."""
    if not rate_std or not clock_limits(stiffness, rate, rate_std):
        return ""
    known = float(f"{1e6 * rate_std / rate:.2g}")
    return (
        f"The recorder's clock limits the stiffness: its rate is known to {known:g} ppm, "
        "and the error of K includes twice that."
    )


def _of_clock(value: Estimate, rate: float, rate_std: float) -> float:
    return abs(seconds_in(value.unit) * value.value) * rate_std / rate
