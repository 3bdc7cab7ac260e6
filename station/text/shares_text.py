"""What each effect does at the largest and at the smallest amplitude, as a table of 80 columns."""

import math
from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from station.results.documents import EstimateDocument
from station.results.shares_document import EffectShareDocument, SharesDocument
from station.text.numbers import DASH, scale, three_figures

WHICH = ("largest", "smallest")
_DECIMALS = {"%": 2, "Hz": 5}
_FIGURES = 4
_WIDTH = 24


def shares_table(shares: Sequence[SharesDocument]) -> Table:
    """Return the shares, an effect a row: first those at the largest amplitude, then those at the smallest."""
    unit = shares[0].effects[0].force.unit
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), header_style="bold")
    first = f"what each effect does\n{at_amplitude(WHICH[0], shares[0])}"
    table.add_column(first, overflow="fold", min_width=_WIDTH)
    for head in (
        f"largest force\n{unit}",
        "of all but\nspring, %",
        "of the loss\n%",
        "frequency\nraised by %",
    ):
        table.add_column(head, justify="right", no_wrap=True)
    for number, (which, at) in enumerate(zip(WHICH, shares, strict=False)):
        if number:
            table.add_row(Text(at_amplitude(which, at), style="bold"))
        for one in at.effects:
            table.add_row(*(Text(cell) for cell in _cells(one)))
    return table


def at_amplitude(which: str, at: SharesDocument) -> str:
    """Return at which amplitude shares are, in words."""
    factor, unit = scale("displacement", at.unit)
    return f"at {three_figures(factor * (at.amplitude or 0.0))} {unit}, the {which}"


def _cells(one: EffectShareDocument) -> tuple[str, ...]:
    share = one.force_percent.value
    return (
        one.effect,
        with_error(one.force),
        DASH if share is None else f"{share:.1f}",
        with_error(one.loss_percent),
        with_error(one.frequency_percent),
    )


def with_error(found: EstimateDocument) -> str:
    """Return "0.5503 ± 0.0003": four figures, or two decimals of a percentage, the error rounded up; "0" for none."""
    value, std = found.value, found.std
    if value is None:
        return DASH
    if value == 0.0 and std == 0.0:
        return "0"
    if found.unit in _DECIMALS:
        most = _DECIMALS[found.unit]
    elif not 1e-3 <= abs(value) < 1e5:
        return three_figures(value) if std is None else _with_power(value, std)
    else:
        most = max(_FIGURES - 1 - math.floor(math.log10(abs(value))), 0)
    if std is None:
        return f"{value:.{most}f}"
    return _rounded(value, std, most)


def _with_power(value: float, std: float) -> str:
    """Return "(2.363 ± 0.006)e-4": a column has no room for the zeros."""
    exponent = math.floor(math.log10(max(abs(value), std)))
    return f"({_rounded(value / 10.0**exponent, std / 10.0**exponent, _FIGURES - 1)})e{exponent}"


def _rounded(value: float, std: float, most: int) -> str:
    """Return a value with its error rounded up, both with the decimals that the error allows, `most` at most."""
    wanted = max(-math.floor(math.log10(std)), 0) if std > 0.0 else most
    decimals = min(wanted, most)
    up = math.ceil(std * 10**decimals - 1e-9) / 10**decimals
    return f"{value:.{decimals}f} ± {up:.{decimals}f}"
