"""Numbers for people: with as many digits as their error allows, and with their unit."""

import math
from collections.abc import Mapping, Sequence

from identify.estimate import Estimate

_PROPER = {"coulomb": "Coulomb", "stribeck": "Stribeck", "maxwell": "Maxwell", "dahl": "Dahl",
           "bouc": "Bouc", "wen": "Wen", "ac": "AC"}  # fmt: skip
"""Words of effects' names that are names of persons, or letters."""

_LARGE, _SMALL = 1e6, 1e-4
"""Sizes outside of which a power of ten is taken out."""

_MANY, _FEW = 99999.5, 1e-6
"""Sizes from which on, and below which, three figures take a power of ten."""

_TENS = 99.5
"""Standard error from which on the digits before the point are rounded too: two of them are figures."""

_MOST_DECIMALS = 9

EXPLAINS_NOTHING, _ALL = 0.005, 0.9995
"""Shares below which nothing is explained, and from which on more digits would be noise."""

_PREFIXED = "NJm"
"""First letters of units that can take a prefix."""


def decimals_for(std: float) -> int:
    """Count the decimals that show two figures of a standard error."""
    if not math.isfinite(std) or std <= 0:
        return 4
    return max(0, 1 - math.floor(math.log10(std)))


def with_error(value: float, std: float) -> str:
    """Return "13115.0 ± 0.4" with the digits that the error allows; "(-1.18 ± 0.10)e6" where they would be many."""
    if not math.isfinite(value):
        return "unknown"
    if not math.isfinite(std):
        return f"{value:.5g} ± unknown"
    if std == 0.0:
        return f"{value:.5g}"
    size = max(abs(value), std)
    if size >= _LARGE or size < _SMALL:
        exponent = math.floor(math.log10(size))
        whole, error = value / 10.0**exponent, std / 10.0**exponent
        decimals = min(decimals_for(error), _MOST_DECIMALS)
        return f"({whole:.{decimals}f} ± {error:.{decimals}f})e{exponent}"
    decimals = decimals_for(std)
    if decimals > _MOST_DECIMALS:
        return f"{value:.{_MOST_DECIMALS}f} ± {std:.1g}"
    if std >= _TENS:
        places = 1 - math.floor(math.log10(std))
        value, std = round(value, places), round(std, places)
    return f"{value:.{decimals}f} ± {std:.{decimals}f}"


def share_words(share: float) -> str:
    """Write the share, 0 to 1, of a residual that an effect explains: "99.9 %", "61 %", "nothing"."""
    if share < EXPLAINS_NOTHING:
        return "nothing"
    if share >= _ALL:
        return "100 %"
    return f"{100.0 * share:.1f} %" if share >= 0.99 else f"{100.0 * share:.0f} %"


def quantity(estimate: Estimate) -> str:
    """Return an estimate with its error, where there is one, and its unit."""
    unit = "" if estimate.unit in ("", "1") else f" {estimate.unit}"
    if not math.isfinite(estimate.std) or estimate.std == 0.0:
        return f"{estimate.value:.4g}{unit}"
    return f"{with_error(estimate.value, estimate.std)}{unit}"


def quantities(found: Mapping[str, Estimate]) -> list[str]:
    """Return each quantity with its name before it; of one that every release has ("fc[0]", "fc[1]", ...) the range."""
    groups: dict[str, list[Estimate]] = {}
    for name, value in found.items():
        groups.setdefault(name.partition("[")[0], []).append(value)
    texts = []
    for name, values in groups.items():
        text = quantity(values[0])
        if len(values) > 1:
            low, high = min(v.value for v in values), max(v.value for v in values)
            unit = "" if values[0].unit in ("", "1") else f" {values[0].unit}"
            text = f"{low:.3g} to {high:.3g}{unit} in {len(values)} releases"
        texts.append(f"{name} = {text}")
    return texts


def identified_rows(stiffness: dict[int, Estimate], damping: tuple[Estimate, ...]) -> list[tuple[str, str]]:
    """Return name and value of each stiffness and damping coefficient by its order."""
    rows = []
    for order, found in stiffness.items():
        rows.append(("stiffness K" if order == 1 else f"stiffness of order {order}", quantity(found)))
    for order, found in enumerate(damping):
        rows.append((damping_name(order), quantity(found)))
    return rows


def damping_name(order: int) -> str:
    """Name the damping coefficient of an order."""
    names = ("dry friction mu_0", "viscous damping mu_1", "quadratic damping mu_2", "cubic damping mu_3")
    return names[order] if order < len(names) else f"damping mu_{order}"


def three_figures(value: float) -> str:
    """Return an error or a ratio with three figures, as "1.24e8" where it would be many digits; "-" where there is none."""
    if not math.isfinite(value):
        return "-"
    if abs(value) >= _MANY or 0.0 < abs(value) < _FEW:
        mantissa, _, exponent = f"{value:.2e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:#.3g}"


def scaled(value: float, unit: str) -> str:
    """Return a number to two figures with its unit, in thousandths where it is small and the unit can take a prefix."""
    if value != 0.0 and abs(value) < 0.01 and unit[:1] in tuple(_PREFIXED) and "^" not in unit.split("/")[0]:
        if abs(value) < 1e-5:
            return f"{value * 1e6:.2g} u{unit}"
        return f"{value * 1e3:.2g} m{unit}"
    return f"{value:.2g} {unit}"


def plain_name(name: str) -> str:
    """Return the name for people of an effect: that for programs with blanks, names of persons with capitals."""
    return " ".join(_PROPER.get(word, word) for word in name.split("_"))


def among(names: Sequence[str], word: str = "and") -> str:
    """Return names as they are listed in a sentence."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"
