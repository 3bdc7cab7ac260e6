"""Numbers and units as they are printed: rounded to the error, powers raised, Greek letters where they belong."""

import math
import re
from typing import Any

from identify.estimate import Estimate

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LARGE, _SMALL = 1e5, 1e-3
SPACE = "\u00a0"  # keeps a number with its error and its unit on one line
_GREEK = {"mu": "μ"}


def unit(text: str) -> str:
    """Return a unit with raised powers: m/s^2 becomes m/s²; "1" (a pure number) becomes nothing."""
    return "" if text == "1" else prose(text).replace(" ", SPACE)


def prose(text: str) -> str:
    """Return a sentence with raised powers and the signs that a terminal has no letters for."""
    raised = re.sub(r"\^(-?\d+)", lambda found: found.group(1).translate(_RAISED), text)
    return re.sub(r"\bu(m|s|J|N)\b", r"µ\1", raised).replace("+-", "±")


def symbol(name: str) -> str:
    """Return a parameter's name as it is printed: mu_0 becomes μ₀."""
    found = re.fullmatch(r"(mu)_(\d)", name)
    return name if found is None else _GREEK[found.group(1)] + found.group(2).translate(_LOWERED)


def lowered(number: int) -> str:
    """Return a number as an index."""
    return str(number).translate(_LOWERED)


def rounded(value: float | None, std: float | None) -> str:
    """Return "13115.0 ± 2.1": the error with two figures, the value with the same decimals.

    A power of ten is taken out where either would need many digits or zeros that mean nothing.
    """
    if value is None or not math.isfinite(value):
        return "unknown"
    if std is None or not math.isfinite(std) or std <= 0.0:
        return f"{_plain(value)} (error unknown)"
    exponent = math.floor(math.log10(max(abs(value), std)))
    last = math.floor(math.log10(std)) - 1
    if float(f"{std:.1e}") >= 10.0 ** (last + 2):
        last += 1
    if last > 0 or exponent >= math.log10(_LARGE) or 10.0**exponent < _SMALL:
        decimals, scale = exponent - last, 10.0**exponent
        power = f"10{str(exponent).translate(_RAISED)}"
        return f"({value / scale:.{decimals}f} ±{SPACE}{std / scale:.{decimals}f}){SPACE}×{SPACE}{power}"
    return f"{value:.{-last}f} ±{SPACE}{std:.{-last}f}"


def _plain(value: float) -> str:
    text = f"{value:.4g}"
    if "e" not in text:
        return text
    mantissa, power = text.split("e")
    return f"{mantissa} × 10{str(int(power)).translate(_RAISED)}"


def with_unit(value: Estimate | dict[str, Any]) -> str:
    """Return a value with its error and its unit, from an estimate or from the dictionary kept of one."""
    if isinstance(value, Estimate):
        value = {"value": value.value, "std": value.std, "unit": value.unit}
    return f"{rounded(value['value'], value['std'])}{SPACE}{unit(str(value['unit']))}".rstrip()


def three(value: float | None) -> str:
    """Return three figures of an error, or a dash where there is none."""
    if value is None or not math.isfinite(value):
        return "–"
    if value != 0 and not _SMALL <= abs(value) < _LARGE:
        mantissa, power = f"{value:.2e}".split("e")
        return f"{mantissa} × 10{str(int(power)).translate(_RAISED)}"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:#.3g}".rstrip(".")
