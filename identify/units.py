"""Units by the powers of what they are made of: read from text, and written."""

from collections.abc import Mapping
from re import findall


def power_in(unit: str, powers: Mapping[str, int]) -> int:
    """Return the power of a quantity in a unit, by its `powers` in the symbols: -2 for {"m": 1} in "1/(m^2 s^2)"."""
    above, below = (
        sum(
            powers.get(name, 0) * int(power or 1)
            for name, power in findall(r"([A-Za-z]+)(?:\^(-?\d+))?", part)
        )
        for part in unit.partition("/")[::2]
    )
    return above - below


def unit_of(powers: Mapping[str, int]) -> str:
    """Write a unit by the powers of its symbols: "N/(m s)" for {"N": 1, "m": -1, "s": -1}."""
    above, below = (
        " ".join(
            name if size == 1 else f"{name}^{size}"
            for name, power in powers.items()
            if (size := sign * power) > 0
        )
        for sign in (1, -1)
    )
    under = f"({below})" if " " in below else below
    return f"{above or '1'}/{under}" if below else above or "1"
