"""Numbers for people: with as many digits as their error allows, and with their unit."""

import math
from collections.abc import Mapping, Sequence
from typing import Protocol

from identify.priors import DECIDES

_PROPER = {"coulomb": "Coulomb", "stribeck": "Stribeck", "maxwell": "Maxwell", "dahl": "Dahl",
           "bouc": "Bouc", "wen": "Wen", "lugre": "LuGre", "ac": "AC"}  # fmt: skip
"""Words of effects' names that are names of persons, or letters."""

DASH = "-"
SPACE = "\u00a0"  # keeps a number with its error and its unit on one line

_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

_LARGE, _SMALL = 1e5, 1e-3
"""Sizes from which on, and below which, a power of ten is taken out."""

_HIDES = 1e4
"""Times a value from which on an error leaves no digit of it: both are written apart."""

EXPLAINS_NOTHING, _ALL = 0.005, 0.9995
"""Shares below which nothing is explained, and from which on more digits would be noise."""

_PREFIXED = "NJmrV"
"""First letters of units that can take a prefix."""


def decimals_for(std: float) -> int:
    """Count the decimals that show two figures of a standard error."""
    if not math.isfinite(std) or std <= 0:
        return 4
    return max(0, 1 - math.floor(math.log10(std)))


class Estimated(Protocol):
    """A value with its standard error and its unit; None in a document where either is not known."""

    @property
    def value(self) -> float | None:
        """The value."""

    @property
    def std(self) -> float | None:
        """Its standard error."""

    @property
    def unit(self) -> str:
        """The unit of both."""


def with_error(value: float | None, std: float | None) -> str:
    """Write "13115.0 ± 2.1": the error with two figures, the value with the same decimals; alone where it is exact.

    A power of ten is taken out where either would need many digits or zeros that mean nothing; where the error leaves no
    digit of the value it stands apart: "4.54 (error 4.80 × 10⁶)".
    """
    if value is None or not math.isfinite(value):
        return "unknown"
    if std is None or not std > 0.0 or math.isinf(std):
        return f"{_power_of_ten(f'{value:.4g}')}{'' if std == 0.0 else ' (error unknown)'}"
    if std > _HIDES * abs(value) > 0.0:
        return f"{_power_of_ten(f'{value:.3g}')} (error {three_figures(std)})"
    exponent = math.floor(math.log10(max(abs(value), std)))
    last = math.floor(math.log10(std)) - 1
    if float(f"{std:.1e}") >= 10.0 ** (last + 2):
        last += 1
    if last > 0 or exponent >= math.log10(_LARGE) or 10.0**exponent < _SMALL:
        decimals, factor = exponent - last, 10.0**exponent
        both = f"({value / factor:z.{decimals}f} ± {std / factor:.{decimals}f})"
        return f"{both} × 10{str(exponent).translate(_RAISED)}".replace(" ", SPACE)
    return f"{value:z.{-last}f} ± {std:.{-last}f}".replace(" ", SPACE)


def share_words(share: float) -> str:
    """Write the share, 0 to 1, of a residual that an effect explains: "99.9 %", "61 %", "nothing"."""
    if share < EXPLAINS_NOTHING:
        return "nothing"
    if share >= _ALL:
        return "100 %"
    return f"{100.0 * share:.1f} %" if share >= 0.99 else f"{100.0 * share:.0f} %"


def quantity(found: Estimated) -> str:
    """Write "13115.0 ± 2.1 N/m", or "0 N (error unknown)"; the value alone where it is exact."""
    number, *unknown = with_error(found.value, found.std).split(" (error")
    return "".join((number, _after(found.unit), *(f" (error{words}" for words in unknown)))


def quantities(found: Mapping[str, Estimated]) -> list[str]:
    """Write "fc = 80.0 ± 1.2 Hz" for each quantity; the range where every release has its own ("fc[0]", "fc[1]")."""
    groups: dict[str, list[Estimated]] = {}
    for name, value in found.items():
        groups.setdefault(name.partition("[")[0], []).append(value)
    texts = []
    for name, values in groups.items():
        text = quantity(values[0])
        if len(values) > 1:
            sizes = [math.nan if one.value is None else one.value for one in values]
            unit = _after(values[0].unit)
            text = f"{min(sizes):.3g} to {max(sizes):.3g}{unit} in {len(values)} releases"
        texts.append(f"{name} = {text}")
    return texts


def _after(unit: str) -> str:
    """Write a unit as it stands after its number; nothing for a pure number."""
    return "" if unit in ("", "1") else f" {unit}".replace(" ", SPACE)


def stiffness_name(order: int) -> str:
    """Name the stiffness of an order."""
    return "stiffness K" if order == 1 else f"stiffness of order {order}"


def damping_name(order: int) -> str:
    """Name the damping coefficient of an order."""
    names = ("dry friction mu_0", "viscous damping mu_1", "quadratic damping mu_2", "cubic damping mu_3")
    return names[order] if order < len(names) else f"damping mu_{order}"


def three_figures(value: float | None) -> str:
    """Write an error or a ratio with three figures, as "1.24 × 10⁸" where it would be many digits; "-" without any."""
    if value is None or not math.isfinite(value):
        return DASH
    if value != 0 and not _SMALL <= abs(value) < _LARGE:
        return _power_of_ten(f"{value:.2e}")
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:#.3g}".rstrip(".")


def odds_words(nats: float) -> str:
    """Write evidence as odds: "25 to 1", "10⁴ to 1"; from where more decides nothing more, "10⁵ to 1 or more"."""
    if nats > DECIDES:
        return f"{odds_words(DECIDES)} or more"
    digits = nats / math.log(10.0)
    return f"{math.exp(nats):.0f} to 1" if digits < 3.0 else f"10{str(round(digits)).translate(_RAISED)} to 1"


def _power_of_ten(text: str) -> str:
    """Write "1.20e-04" as 1.20 × 10⁻⁴."""
    mantissa, e, power = text.partition("e")
    return f"{mantissa} × 10{str(int(power)).translate(_RAISED)}" if e else mantissa


def two_figures(value: float) -> str:
    """Write a number with two figures: "0.16", "920"; "9.2 × 10⁶" where it would be many digits."""
    return _power_of_ten(f"{float(f'{value:.2g}'):g}")


def scaled(value: float, unit: str) -> str:
    """Return a number to two figures with its unit, in thousandths where it is small and the unit can take a prefix."""
    if value != 0.0 and abs(value) < 0.01 and unit[:1] in tuple(_PREFIXED) and "^" not in unit.split("/")[0]:
        if abs(value) < 1e-5:
            return f"{two_figures(value * 1e6)} u{unit}"
        return f"{two_figures(value * 1e3)} m{unit}"
    return f"{two_figures(value)} {unit}"


def plain_name(name: str) -> str:
    """Return the name for people of an effect: that for programs with blanks, names of persons with capitals."""
    return " ".join(_PROPER.get(word, word) for word in name.split("_"))


def sentence_case(words: str) -> str:
    """Begin some words with a capital, and leave the others as they are: names of persons keep theirs."""
    return words[:1].upper() + words[1:]


def among(names: Sequence[str], word: str = "and") -> str:
    """Return names as they are listed in a sentence."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"
