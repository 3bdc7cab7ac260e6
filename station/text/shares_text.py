"""The table of what each effect does at the largest and at the smallest amplitude."""

import math
from collections.abc import Sequence

from identify.formatting import DASH, three_figures, with_error
from station.results.diagnosis_parts import SharesDocument
from station.results.documents import EstimateDocument
from station.text.content import Table
from station.text.numbers import scale, typeset_unit

_DECIMALS = {"%": 2, "Hz": 5}
_FIGURES = 4


def shares_tables(shares: Sequence[SharesDocument]) -> tuple[Table, ...]:
    """Make a table for the largest and one for the smallest amplitude, an effect a row; none where nothing is known."""
    found = []
    for which, at in zip(("largest", "smallest"), shares, strict=False):
        factor, unit = scale("displacement", at.unit)
        rows = tuple(
            (one.effect, _cell(one.force), three_figures(one.force_percent.value), _cell(one.loss_percent),
             _cell(one.frequency_percent))
            for one in at.effects
        )  # fmt: skip
        size = f"{three_figures(factor * (at.amplitude or 0.0))} {unit}"
        head = (
            f"at {size},\nthe {which}", f"largest force\n{typeset_unit(at.effects[0].force.unit)}",
            "of all but\nspring, %", "of the loss\n%", "frequency\nraised by %",
        )  # fmt: skip
        found.append(Table("", head, rows))
    return tuple(found)


def _cell(found: EstimateDocument) -> str:
    """Write four figures of a value, or two decimals of a percentage, with the error rounded up; "0" for none."""
    value, std = found.value, found.std
    if value is None or (value == 0.0 and std == 0.0):
        return DASH if value is None else "0"
    if found.unit not in _DECIMALS and not 1e-3 <= abs(value) < 1e5:
        return three_figures(value) if std is None else with_error(value, std)
    most = _DECIMALS.get(found.unit) or max(_FIGURES - 1 - math.floor(math.log10(abs(value))), 0)
    if std is None:
        return f"{value:.{most}f}"
    decimals = min(max(-math.floor(math.log10(std)), 0) if std > 0.0 else most, most)
    up = math.ceil(std * 10**decimals - 1e-9) / 10**decimals
    return f"{value:.{decimals}f} ± {up:.{decimals}f}"
