"""The measured curve: a force that has no name, as a spline of a few knots over the coordinate it depends on.

It is written in one line, such as `measured_curve = spline(u, -0.02, 0.02, 4)`: a cubic spline of five intervals over
the displacement from -0.02 to 0.02, its six coefficients given in units of the fourth. Beyond its ends it stays level.
Before `spline` may stand what it multiplies: `sgn(v)*` makes it a dry friction, `u*` and `v*` a stiffness or damping.
The straight line and the constant are left to the spring and its zero: of the eight B-splines of five intervals the
inner six are enough beside them (de Boor, A Practical Guide to Splines, 1978, ch. IX).
"""

import re
from dataclasses import dataclass
from functools import lru_cache
from math import isfinite
from typing import Any

import numpy as np

from identify.arrays import Array
from identify.effects.compiled import effect_function
from identify.effects.effect import Parameter
from identify.effects.force_effect import ForceEffect

COUNT = 6
"""Coefficients: the strength and five ratios, all that an effect can have."""

_LINE = re.compile(
    r"(?:(?P<factor>sgn\(v\)|u|v)\s*\*\s*)?spline\(\s*(?P<over>u|v|t|abs\(v\))\s*,(?P<low>[^,()]+),(?P<high>[^,()]+),"
    r"\s*(?P<unit>[1-6])\s*\)"
)
_UNITS = {"": "m/s^2", "sgn(v)": "m/s^2", "u": "1/s^2", "v": "1/s"}
_WHAT = {"": "force", "sgn(v)": "dry friction", "u": "stiffness", "v": "damping"}
_OVER = {"u": "displacement", "v": "velocity", "t": "time", "abs(v)": "speed"}


@dataclass(frozen=True)
class CurveForm:
    """What a measured curve runs over ("u", "v", "abs(v)" or "t"), from `low` to `high`, and what it multiplies.

    `factor` is "" for a force, "sgn(v)" for a dry friction, "u" for a stiffness, "v" for a damping. `unit` (1 to 6) is
    the coefficient in units of which the others are given.
    """

    factor: str
    over: str
    low: float
    high: float
    unit: int

    @property
    def formula(self) -> str:
        """The right side of the line in which it is kept."""
        before = f"{self.factor}*" if self.factor else ""
        return f"{before}spline({self.over}, {self.low:.6g}, {self.high:.6g}, {self.unit})"

    def position(self, time: Array, u: Array, v: Array) -> Array:
        """Return the position of a motion along the curve, shape (n,)."""
        return {"u": u, "v": v, "t": time, "abs(v)": np.abs(v)}[self.over]

    def multiplied(self, u: Array, v: Array) -> Array:
        """Return what the curve multiplies along a motion, shape (n,)."""
        return {"": np.ones_like(u), "sgn(v)": np.sign(v), "u": u, "v": v}[self.factor]

    def basis(self, position: Array) -> Array:
        """Return the six B-splines at positions (n,), shape (n, 6)."""
        step = (self.high - self.low) / (COUNT - 1)
        y = (np.clip(position, self.low, self.high) - self.low) / step
        away = np.abs(y[:, None] - np.arange(COUNT))
        return np.asarray((np.maximum(2.0 - away, 0.0) ** 3 - 4.0 * np.maximum(1.0 - away, 0.0) ** 3) / 6.0)

    def along(self, time: Array, u: Array, v: Array) -> Array:
        """Return the force of each coefficient along a motion, shape (n, 6)."""
        return np.asarray(self.basis(self.position(time, u, v)) * self.multiplied(u, v)[:, None])


def read_curve(formula: str) -> CurveForm | None:
    """Return the measured curve that a formula describes, None where it is another formula; ValueError for wrong ends."""
    found = _LINE.fullmatch(formula.strip())
    if found is None:
        return None
    try:
        low, high = float(found["low"]), float(found["high"])
    except ValueError as error:
        raise ValueError(f"'{formula.strip()[:60]}': the ends of the spline are not numbers") from error
    if not (isfinite(low) and isfinite(high) and low < high):
        raise ValueError(f"'{formula.strip()[:60]}': a spline runs from a smaller number to a larger one")
    return CurveForm(found["factor"] or "", found["over"], low, high, int(found["unit"]))


def curve_effect(name: str, form: CurveForm, ratios: tuple[float, ...] = (0.0,) * (COUNT - 1)) -> ForceEffect:
    """Return a measured curve as an effect: a strength and five ratios to it, which a fit begins at `ratios`."""
    what, over = _WHAT[form.factor], _OVER[form.over]
    others = [number for number in range(1, COUNT + 1) if number != form.unit]
    function = _compiled(form)
    friction = form.factor == "sgn(v)"
    return ForceEffect(
        name=name,
        title=f"the measured curve: {what} over the {over}",
        equation=f"{form.factor}*s({form.over})" if form.factor else f"s({form.over})",
        parameters=(
            Parameter("a", _UNITS[form.factor], f"coefficient {form.unit} of the spline, per unit mass"),
            *(
                Parameter(f"r{i}", "1", f"coefficient {i} of the spline over coefficient {form.unit}")
                for i in others
            ),
        ),
        force=None if friction else function,
        friction=function if friction else None,
        starts=lambda scales: (ratios,),
        nonsmooth=True,
        of_time=form.over == "t",
        rarity=2,
        symptom="what was measured, as a curve",
        confirming_test="another release: a force that belongs to the bench is the same curve there",
    )


@lru_cache(maxsize=32)
def _compiled(form: CurveForm) -> Any:
    """Compile a curve once, however many effects have its form: that takes half a second."""
    low, high, unit, count = form.low, form.high, form.unit - 1, COUNT
    step = (high - low) / (count - 1)
    over, factor = tuple(_OVER).index(form.over), tuple(_UNITS).index(form.factor)

    def value(t, u, v, z, p):  # type: ignore[no-untyped-def]
        x = u if over == 0 else v if over == 1 else t if over == 2 else abs(v)
        y = (min(max(x, low), high) - low) / step
        total, k = 0.0, 1
        for i in range(count):
            weight = 1.0
            if i != unit:
                weight = p[k]
                k += 1
            away = abs(y - i)
            total += weight * (max(2.0 - away, 0.0) ** 3 - 4.0 * max(1.0 - away, 0.0) ** 3)
        multiplied = u if factor == 2 else v if factor == 3 else 1.0
        return multiplied * (p[0] * total / 6.0)

    return effect_function(value, cache=False)
