"""How numbers are written for people: a value and its error with as many digits as the error allows."""

import math

from identify.estimate import Estimate


def digits_for(std: float) -> int:
    """Return how many decimals show two figures of a standard error."""
    if not math.isfinite(std) or std <= 0:
        return 4
    return max(0, 1 - math.floor(math.log10(std)))


def with_error(value: float, std: float) -> str:
    """Return "13115.0 ± 0.4" with the digits that the error allows."""
    if not math.isfinite(value):
        return "unknown"
    if not math.isfinite(std):
        return f"{value:.5g} ± unknown"
    if abs(value) >= 1e6 or 0 < abs(value) < 1e-4:
        return f"{value:.4g} ± {std:.1g}"
    decimals = digits_for(std)
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def written(estimate: Estimate) -> str:
    """Return an estimate with its error, without its unit."""
    return with_error(estimate.value, estimate.std)


DAMPING_NAMES = ("dry friction mu_0", "viscous damping mu_1", "quadratic damping mu_2", "cubic damping mu_3")


def damping_name(order: int) -> str:
    """Return what the damping coefficient of an order is called."""
    return DAMPING_NAMES[order] if order < len(DAMPING_NAMES) else f"damping mu_{order}"


def shown(channel: str, unit: str, fine: bool = False) -> tuple[float, str]:
    """Return the factor to the unit in which a channel is shown, and that unit.

    `unit` is that of the displacement (m, rad, or what a sensor gave, as V). `fine` chooses a thousand
    times smaller unit, for noise and for what a model leaves.
    """
    if channel == "displacement":
        plain, small = {"m": ((1e3, "mm"), (1e6, "um")), "rad": ((1.0, "rad"), (1e3, "mrad"))}.get(
            unit, ((1.0, unit), (1e3, f"m{unit}"))
        )
        return small if fine else plain
    return 1.0, f"{unit}/s" if channel == "velocity" else f"{unit}/s^2"
