"""Fingerprints: the force that a model lacks, and what a suspect would add, over the phase plane and over the cycle.

Both are taken along the measured motion after the base model has been refitted, so that they show only what the
base cannot follow; of the right suspect the two look alike.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask
from identify.fitting.baseline import force_along_motion
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import Setting

RINGS = 9
ANGLES = 30
_FEWEST = 1


@dataclass(frozen=True, eq=False)
class Fingerprint:
    """A force per unit mass by amplitude and phase of the cycle.

    `amplitude` (rings + 1,) and `phase` (angles + 1,) are the edges of the bins, `force` (rings, angles) the means, nan
    where there are too few samples. The phase is 0 at the largest displacement and grows with time (rad); amplitudes are
    in the unit of the displacement. `large` and `small` (angles,) are the means over the outer and the inner half.
    """

    amplitude: Array
    phase: Array
    force: Array
    large: Array
    small: Array


def force_left(setting: Setting, base: Fit) -> Array:
    """Return the force per unit mass that a model leaves along the measured motion, shape (n,)."""
    return setting.restoring - force_along_motion(setting, base)


def force_added(setting: Setting, base: Fit, found: Fit, term: Term, index: int = 0) -> Array:
    """Return what a suspect adds to the base's force where the base cannot follow, shape (n,).

    `found` is the base refitted with `term`, `index` the place of the setting among its spans. A sensor's fault counts
    as the force that it feigns.
    """
    if term.effect.kind == "physics":
        return force_along_motion(setting, found) - force_along_motion(setting, base)
    feigned = _feigned(setting, found, term, index)
    motion = setting.motion
    design = np.column_stack(
        [motion.displacement, motion.velocity, np.sign(motion.velocity), np.ones(len(feigned))]
    )
    used = moving(motion)
    weights = np.linalg.lstsq(design[used], feigned[used], rcond=1e-12)[0]
    return np.asarray(feigned - design @ weights)


def _feigned(setting: Setting, found: Fit, term: Term, index: int) -> Array:
    """Return the force per unit mass that a sensor's fault feigns: in the acceleration itself, or by the stiffness."""
    effect, channel = term.effect, term.channel
    span = found.spans[index]
    if effect.observe is None or channel not in span.readings:
        return np.zeros(len(span))
    tag = f"[{index}]" if len(found.spans) > 1 else ""
    p = np.array([found.values[f"{effect.name}.{q.name}{tag}"].value for q in effect.parameters])
    motion = setting.motion
    clean = {
        "displacement": motion.displacement,
        "velocity": motion.velocity,
        "acceleration": motion.acceleration,
    }[channel]
    error = effect.observe(span.clock, clean, p) - clean
    factor = {"acceleration": -1.0, "displacement": -(found.frequency**2), "velocity": -found.frequency}
    return np.asarray(factor[channel] * error)


def fingerprint(setting: Setting, force: Array) -> Fingerprint:
    """Sort a force along the measured motion, shape (n,), by amplitude and phase of the cycle."""
    motion = setting.motion
    used = moving(motion) & np.isfinite(force)
    size = np.hypot(motion.displacement, motion.velocity / setting.frequency)
    angle = np.mod(np.arctan2(-motion.velocity / setting.frequency, motion.displacement), 2.0 * np.pi)
    amplitude = np.linspace(float(size[used].min()), float(size[used].max()) * (1.0 + 1e-9), RINGS + 1)
    phase = np.linspace(0.0, 2.0 * np.pi, ANGLES + 1)
    ring = np.clip(np.digitize(size, amplitude) - 1, 0, RINGS - 1)
    sector = np.clip(np.digitize(angle, phase) - 1, 0, ANGLES - 1)
    outer = ring >= RINGS // 2
    return Fingerprint(
        amplitude,
        phase,
        _means(ring * ANGLES + sector, force, used, RINGS * ANGLES).reshape(RINGS, ANGLES),
        _means(sector, force, used & outer, ANGLES),
        _means(sector, force, used & ~outer, ANGLES),
    )


def _means(place: NDArray[np.signedinteger[Any]], force: Array, used: Mask, bins: int) -> Array:
    count = np.bincount(place[used], minlength=bins)
    total = np.bincount(place[used], weights=force[used], minlength=bins)
    return np.where(count >= _FEWEST, total / np.maximum(count, 1), np.nan)
