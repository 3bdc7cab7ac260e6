"""An estimate: a number, its standard error and its unit."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Estimate:
    """A value with its standard error (one standard deviation) in the same unit."""

    value: float
    std: float
    unit: str
