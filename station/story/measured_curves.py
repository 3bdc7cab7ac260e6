"""The measured curves in a fitted model: the force that has no name, with its error, over what it depends on."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from identify.effects.user.measured_curve import COUNT, CurveForm, read_curve
from identify.fitting.fit import Fit
from identify.signal.smoothing import without_line

POINTS = 200


@dataclass(frozen=True, eq=False)
class MeasuredCurve:
    """One curve: what it runs over (shape (n,), SI), its value per unit mass there and the standard error.

    The straight line through it is left out where the spring or the damper of the model has one of its own.
    """

    name: str
    title: str
    over: str
    unit: str
    position: Array
    value: Array
    std: Array
    value_unit: str


def measured_curves(fit: Fit, expressions: Iterable[str]) -> tuple[MeasuredCurve, ...]:
    """Return the measured curves of a fit; `expressions` are the lines by which a model keeps its own effects."""
    found = []
    for line in expressions:
        name, _, formula = (part.strip() for part in line.partition("="))
        form = read_curve(formula)
        if form is not None and name in fit.model:
            found.append(_curve(fit, name, form))
    return tuple(found)


def _curve(fit: Fit, name: str, form: CurveForm) -> MeasuredCurve:
    term = next(term for term in fit.model.forces if term.effect.name == name)
    names = [str(term.parameter(parameter.name)) for parameter in term.effect.parameters]
    strength, *ratios = (fit.values[one].value for one in names)
    others = [i for i in range(COUNT) if i != form.unit - 1]
    position = np.linspace(form.low, form.high, POINTS)
    splines = form.basis(position)
    shape = splines[:, form.unit - 1] + splines[:, others] @ np.array(ratios)
    left = without_line if form.factor in ("", "sgn(v)") else np.asarray
    slope = np.apply_along_axis(left, 0, np.column_stack([shape, strength * splines[:, others]]))
    at = [fit.names.index(one) for one in names]
    variance = np.einsum("ni,ij,nj->n", slope, fit.covariance[np.ix_(at, at)], slope)
    length = fit.windows[0].unit
    unit = {"u": length, "v": f"{length}/s", "abs(v)": f"{length}/s", "t": "s"}[form.over]
    return MeasuredCurve(
        name,
        term.effect.title,
        term.effect.title.rpartition("over the ")[2],
        unit,
        position,
        left(strength * shape),
        np.sqrt(np.maximum(variance, 0.0)),
        fit.values[names[0]].unit,
    )
