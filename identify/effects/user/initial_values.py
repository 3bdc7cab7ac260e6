"""Starting values for a user's own effect: from its parameters' units, and the sizes in the data."""

import re
from itertools import product
from math import isfinite, pi, prod

import numpy as np

from identify.effects.effect import Parameter, Scales
from identify.units import power_in

_MOST = 48
_FACTOR = re.compile(r"(m|s|rad|Hz|1)(?:\^(-?\d))?")
_SPREAD = (0.3, 1.0, 3.0)
_PHASES = (0.8, 2.4, 3.9, 5.5)
_LENGTHS = (0.1, 0.3, 0.6)
_PLACES = (0.15, 0.3, 0.45, 0.6, 0.8)
_OF_THE_DURATION = (0.3, 1.0)
_NUMBERS = (0.5, 1.0, 2.0)
_FREQUENCIES = (0.5, 2.0, 3.0)


Choice = tuple[tuple[float, ...], tuple[float, ...]]
"""Starting values of one parameter: likely ones, which are combined first, and others. Without a unit a length is likely."""


def dimensions_of(unit: str) -> tuple[int, int, str]:
    """Return the powers of length and of time in a unit such as "1/(m^2 s^2)", and its kind: "", "rad" or "Hz".

    Lengths are "m" whatever the displacement is measured in. ValueError when the unit is made of anything else.
    """
    factors = re.split(r"[ ()*/]+", unit.strip(" ()"))
    if not unit.partition("/")[0].strip():
        raise ValueError(f"the unit '{unit}' has nothing above the stroke; write 1{unit}")
    found = [_FACTOR.fullmatch(factor) for factor in factors]
    if None in found:
        raise ValueError(f"the unit '{unit}' is not made of m, s, rad, Hz and 1 (forces are per unit mass)")
    kinds = {one[1] for one in found if one is not None}
    kind = "rad" if "rad" in kinds else "Hz" if "Hz" in kinds else ""
    return power_in(unit, {"m": 1}), power_in(unit, {"s": 1, "Hz": -1}), kind


def problem_of(parameter: Parameter, starts: tuple[float, ...]) -> tuple[str, str] | None:
    """Find what is wrong with a parameter ("unit", "bounds" or "start") and say it in a sentence; None where nothing is."""
    name, low, high = parameter.name, parameter.low, parameter.high
    try:
        dimensions_of(parameter.unit or "1")
    except ValueError as error:
        return "unit", f"{name}: {error}"
    if not low < high:
        return "bounds", f"{name} cannot lie between {low:g} and {high:g}"
    outside = [value for value in starts if not isfinite(value) or not low <= value <= high]
    return ("start", f"{name} cannot start at {outside[0]:g}, outside its bounds") if outside else None


def combinations(choices: list[Choice]) -> tuple[tuple[float, ...], ...]:
    """Return combinations of one value from each choice: first the likely values, then others as room allows."""
    likely = _drawn([first for first, _ in choices])
    both = _drawn([first + others for first, others in choices])
    return tuple(dict.fromkeys((*likely, *both)))[:_MOST]


def _drawn(choices: list[tuple[float, ...]]) -> tuple[tuple[float, ...], ...]:
    """Return all combinations of one value from each, or, of too many, some drawn evenly."""
    total = prod(len(c) for c in choices)
    if total <= _MOST:
        return tuple(product(*choices))
    places = np.sort(np.random.default_rng(0).choice(total, _MOST, replace=False))
    columns = zip(choices, np.unravel_index(places, [len(c) for c in choices]), strict=True)
    return tuple(zip(*([choice[i] for i in at] for choice, at in columns), strict=True))


def starts_of(parameter: Parameter, given: tuple[float, ...], scales: Scales, *, even: bool) -> Choice:
    """Return starting values of one inner parameter: those given, or its unit's on the data's scales.

    A length that the force is not `even` in is a place, and tried on both sides.
    """
    if given:
        return given, ()
    likely = _by_unit(parameter.unit or "m", scales)
    if parameter.unit in ("m", "") and not even:
        likely = tuple(side * share * scales.amplitude for share in _PLACES for side in (1.0, -1.0))
    others: tuple[float, ...] = ()
    if not parameter.unit:
        others = tuple(value for unit in ("m/s", "s", "1") for value in _by_unit(unit, scales))
    likely, others = (
        tuple(v for v in values if parameter.low <= v <= parameter.high) for values in (likely, others)
    )
    return likely or others or _between(parameter), others if likely else ()


def _by_unit(unit: str, scales: Scales) -> tuple[float, ...]:
    length, time, kind = dimensions_of(unit)
    period = 2.0 * pi / scales.frequency
    if (length, time) == (0, 0):
        return _PHASES if kind == "rad" else _NUMBERS
    if (length, time) == (0, -1) and kind:
        hertz = [*scales.line_frequencies, *(share / period for share in _FREQUENCIES)]
        return tuple((2.0 * pi if kind == "rad" else 1.0) * f for f in hertz)
    if (length, time) == (1, 0):
        return tuple(share * scales.amplitude for share in _LENGTHS)
    if (length, time) == (1, -1):
        return tuple(share * scales.speed for share in _LENGTHS)
    if (length, time) == (0, 1):
        return (
            *(share * period for share in _SPREAD),
            *(share * scales.duration for share in _OF_THE_DURATION),
        )
    size = scales.amplitude**length * (1.0 / scales.frequency) ** time
    return tuple(share * size for share in _SPREAD)


def _between(parameter: Parameter) -> tuple[float, ...]:
    """Return values inside the bounds, where those of the scales all lie outside."""
    low, high = parameter.low, parameter.high
    if isfinite(low) and isfinite(high):
        if low > 0.0 and high > 10.0 * low:
            return tuple(float(x) for x in np.geomspace(low, high, 5)[1:-1])
        return tuple(low + share * (high - low) for share in (0.2, 0.5, 0.8))
    if low > 0.0:
        return 2.0 * low, 10.0 * low
    return (0.5 * high, high - 1.0) if high > 0.0 else (2.0 * high, 10.0 * high)
