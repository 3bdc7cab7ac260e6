"""Numbers and units for people, in a terminal and, typeset, on a page."""

import math
import re
from collections.abc import Mapping

from identify import formatting
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.estimate import Estimate
from station.results.documents import EstimateDocument
from station.results.models import Value

DASH = "-"
SPACE = "\u00a0"  # keeps a number with its error and its unit on one line
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LARGE, _SMALL = 1e5, 1e-3


Estimated = Estimate | EstimateDocument | Value
"""A value with its standard error and its unit; None in a document where either is not known."""


def or_nan(value: float | None) -> float:
    """Write nan where a number is not known."""
    return math.nan if value is None else value


def with_error(value: float | None, std: float | None) -> str:
    """Write "13115.0 ± 2.1": the error with two figures, the value with the same decimals.

    A power of ten is taken out where either would need many digits or zeros that mean nothing.
    """
    if value is None or not math.isfinite(value):
        return "unknown"
    if std is None or not math.isfinite(std) or std <= 0.0:
        return f"{_power_of_ten(f'{value:.4g}')} (error unknown)"
    exponent = math.floor(math.log10(max(abs(value), std)))
    last = math.floor(math.log10(std)) - 1
    if float(f"{std:.1e}") >= 10.0 ** (last + 2):
        last += 1
    if last > 0 or exponent >= math.log10(_LARGE) or 10.0**exponent < _SMALL:
        decimals, factor = exponent - last, 10.0**exponent
        power = f"10{str(exponent).translate(_RAISED)}"
        return (
            f"({value / factor:.{decimals}f}{SPACE}±{SPACE}{std / factor:.{decimals}f}){SPACE}×{SPACE}{power}"
        )
    return f"{value:.{-last}f}{SPACE}±{SPACE}{std:.{-last}f}"


def with_unit(found: Estimated) -> str:
    """Write "13115.0 ± 2.1 N/m"; without an error where none is known."""
    if found.value is not None and not found.std:
        number = _power_of_ten(f"{found.value:.4g}")
    else:
        number = with_error(found.value, found.std)
    return f"{number}{SPACE}{typeset_unit(found.unit)}".rstrip()


def with_names(found: Mapping[str, Estimated]) -> list[str]:
    """Write "fc = 80.0 ± 1.2 Hz" for each parameter; the range where every release has its own ("fc[0]", "fc[1]")."""
    groups: dict[str, list[Estimated]] = {}
    for name, value in found.items():
        groups.setdefault(name.partition("[")[0], []).append(value)
    texts = []
    for name, values in groups.items():
        text = with_unit(values[0])
        if len(values) > 1:
            sizes = [or_nan(one.value) for one in values]
            unit = typeset_unit(values[0].unit)
            text = f"{min(sizes):.3g} to {max(sizes):.3g} {unit} in {len(values)} releases".replace("  ", " ")
        texts.append(f"{typeset_symbol(name)} = {text}")
    return texts


def three_figures(value: float | None) -> str:
    """Write an error or a ratio with three figures; a dash where there is none."""
    if value is None or not math.isfinite(value):
        return DASH
    if value != 0 and not _SMALL <= abs(value) < _LARGE:
        return _power_of_ten(f"{value:.2e}")
    return formatting.three_figures(value).rstrip(".")


def probability(p: float | None) -> str:
    """Return a probability as people read it."""
    if p is None or not math.isfinite(p):
        return DASH
    return "<1e-6" if p < 1e-6 else f"{p:.0e}".replace("e-0", "e-") if p < 0.01 else f"{p:.2f}"


def change(before: float | None, after: float | None) -> str:
    """Say by how much something fell or rose, as a factor or in %."""
    if not before or not after:
        return ""
    if before >= 2 * after > 0:
        return f"÷ {before / after:.3g}"
    if after >= 2 * before > 0:
        return f"x {after / before:.3g}"
    percent = 100 * (after - before) / abs(before)
    return f"{percent:+.1f} %" if abs(percent) >= 0.1 else f"{percent:+.2g} %"


# Units.


def scale(channel: str, unit: str, fine: bool = False) -> tuple[float, str]:
    """Return the factor to the unit in which a channel is shown, and that unit.

    `unit` is that of the displacement (m, rad, or what a sensor gave, as V). `fine` chooses a thousand
    times smaller unit, for noise and for what a model leaves.
    """
    if channel == "displacement":
        whole = unit in ("count", "px")  # nobody speaks of a thousandth of a count
        plain, small = {"m": ((1e3, "mm"), (1e6, "um")), "rad": ((1.0, "rad"), (1e3, "mrad"))}.get(
            unit, ((1.0, unit), (1.0, unit) if whole else (1e3, f"m{unit}"))
        )
        return small if fine else plain
    return 1.0, f"{unit}/s" if channel == "velocity" else f"{unit}/s^2"


def noise_scale(channel: str, unit: str, noise: float) -> tuple[float, str]:
    """Return the scale in which a channel's noise is shown: the fine one unless that makes a thousand or more of it."""
    fine = scale(channel, unit, fine=True)
    return fine if noise * fine[0] < 1000.0 else scale(channel, unit)


def scale_as_recorded(quantity: str, unit: str) -> tuple[float, str]:
    """Return the same for a channel in its own `unit`: lengths in mm, everything else as it was recorded."""
    return scale("displacement", unit) if quantity == "displacement" else (1.0, unit)


def energy_scale(units: DiscrepancyText) -> tuple[float, str]:
    """Return the factor on an energy per unit mass to the unit in which it is shown, and that unit: mJ, mJ/kg ..."""
    fine, prefix = (1e3, "m") if units.energy_unit.startswith("J") else (1.0, "")
    return fine * units.force_scale, f"{prefix}{units.energy_unit}"


# Typeset: raised powers, Greek letters, powers of ten.


def typeset(text: str) -> str:
    """Return a sentence with raised powers and the signs that a terminal has no letters for."""
    raised = re.sub(r"\^(-?\d+)", lambda found: found.group(1).translate(_RAISED), text)
    return re.sub(r"\bu(m|s|J|N)\b", r"µ\1", raised).replace("+-", "±")


def typeset_unit(text: str) -> str:
    """Return a unit with raised powers: m/s^2 becomes m/s²; "1" (a pure number) becomes nothing."""
    return "" if text == "1" else typeset(text).replace(" ", SPACE)


def typeset_symbol(name: str) -> str:
    """Return a parameter's name as it is printed: mu_0 becomes μ₀."""
    found = re.fullmatch(r"mu_(\d)", name)
    return name if found is None else f"μ{lowered(int(found.group(1)))}"


def lowered(number: int) -> str:
    """Return a number as an index."""
    return str(number).translate(_LOWERED)


def _power_of_ten(text: str) -> str:
    """Return "1.20e-04" as 1.20 × 10⁻⁴."""
    mantissa, e, power = text.partition("e")
    return f"{mantissa} × 10{str(int(power)).translate(_RAISED)}" if e else mantissa
