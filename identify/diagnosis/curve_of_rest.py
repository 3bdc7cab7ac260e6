"""The curve of what is left: what a model does not explain, as a spline over the coordinate that it depends on."""

import numpy as np

from identify.arrays import Array
from identify.diagnosis.verdict import free_form
from identify.effects.force_effect import ForceEffect
from identify.effects.user.measured_curve import COUNT, CurveForm, curve_effect
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, force_along_motion
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay

_FORMS = {
    "displacement": ("", "u"),
    "velocity": ("", "v"),
    "friction over displacement": ("sgn(v)", "u"),
    "friction over speed": ("sgn(v)", "abs(v)"),
    "time (stiffness)": ("u", "t"),
    "time (damping)": ("v", "t"),
    "time (friction)": ("sgn(v)", "t"),
}
"""What the curve multiplies and what it runs over, by the name of the free form's coordinate."""

_LEAST = 1e-3
"""Smallest share of a coefficient of the largest, below which its ratio would have no meaning."""


def curve_of_rest(baseline: Baseline, name: str) -> tuple[ForceEffect, str]:
    """Return the measured curve of what a fitted model leaves, as an effect called `name`, and the line that keeps it.

    The coordinate is the one that explains most of cycles that were held out; the curve begins at a regression of the
    missing force on the release of the largest amplitude. Raises NotIdentifiable where no smooth curve explains any.
    """
    shape = free_form(baseline, baseline.fit)
    if not shape.shapes or not shape.coordinates:
        raise NotIdentifiable(
            "what the model leaves follows no curve in displacement, velocity or time, so there is none to add"
        )
    prepared = max(baseline.decays, key=lambda decay: decay.amplitude)
    factor, over = _FORMS[shape.coordinates[0]]
    form = _over_the_motion(prepared, factor, over)
    weights = _regressed(prepared, prepared.restoring - force_along_motion(prepared, baseline.fit), form)
    largest = int(np.argmax(np.abs(weights)))
    form = CurveForm(factor, over, form.low, form.high, largest + 1)
    ratios = tuple(float(weights[i] / weights[largest]) for i in range(COUNT) if i != largest)
    return curve_effect(name, form, ratios), f"{name} = {form.formula}"


def _over_the_motion(prepared: PreparedDecay, factor: str, over: str) -> CurveForm:
    """Return the curve from end to end of what the motion reaches, rounded as it is kept."""
    form = CurveForm(factor, over, 0.0, 1.0, 1)
    motion = prepared.motion
    position = form.position(prepared.time, motion.displacement, motion.velocity)
    low, high = (float(f"{edge:.6g}") for edge in (np.min(position), np.max(position)))
    return CurveForm(factor, over, 0.0 if over == "abs(v)" else low, high, 1)


def _regressed(prepared: PreparedDecay, force: Array, form: CurveForm) -> Array:
    """Return the six coefficients that explain most of a force along the motion, spring and friction made room for."""
    motion = prepared.motion
    columns = form.along(prepared.time, motion.displacement, motion.velocity)
    usual = np.column_stack(
        [motion.displacement, motion.velocity, np.sign(motion.velocity), np.ones(len(force))]
    )
    used = moving(motion)
    design = np.column_stack([columns, usual])[used]
    size = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    weights = np.linalg.lstsq(design / size, force[used], rcond=1e-9)[0][:COUNT] / size[:COUNT]
    return np.asarray(np.where(np.abs(weights) < _LEAST * np.abs(weights).max(), 0.0, weights))
