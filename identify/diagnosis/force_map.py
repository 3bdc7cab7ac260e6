"""Force maps: the force that a model lacks, and what a suspect would add, by amplitude and phase of the cycle.

Both are computed along the measured motion after the base model was refitted, so they show only what the
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
from identify.preprocessing.prepared_decay import PreparedDecay

RINGS = 9
ANGLES = 30


@dataclass(frozen=True, eq=False)
class ForceMap:
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


def force_left(prepared: PreparedDecay, base: Fit, index: int) -> Array:
    """Return the force per unit mass that a model leaves along the motion of the release at a place, shape (n,)."""
    return prepared.restoring - force_along_motion(prepared, base, index)


def force_added(prepared: PreparedDecay, base: Fit, found: Fit, term: Term, index: int = 0) -> Array:
    """Return the part of a suspect's force that the base cannot follow, shape (n,).

    `found` is the base refitted with `term`, `index` the place of the release among its windows. A sensor's fault counts
    as the force for which it would be taken.
    """
    if term.is_force:
        return force_along_motion(prepared, found, index) - force_along_motion(prepared, base, index)
    seeming = _as_force(prepared, found, term, index)
    motion = prepared.motion
    design = np.column_stack(
        [motion.displacement, motion.velocity, np.sign(motion.velocity), np.ones(len(seeming))]
    )
    used = moving(motion)
    weights = np.linalg.lstsq(design[used], seeming[used], rcond=1e-12)[0]
    return np.asarray(seeming - design @ weights)


def _as_force(prepared: PreparedDecay, found: Fit, term: Term, index: int) -> Array:
    """Return the force per unit mass that a sensor's fault looks like: directly, or by the stiffness."""
    fault, channel = term.fault, term.channel
    window = found.windows[index]
    if fault.corrected_in_every_fit or channel not in window.readings:
        return np.zeros(len(window))
    values = found.of(term, index)
    p = np.array([values[q.name].value for q in fault.parameters])
    motion = prepared.motion
    clean = {
        "displacement": motion.displacement,
        "velocity": motion.velocity,
        "acceleration": motion.acceleration,
    }[channel]
    error = fault.observe(window.clock, clean, p) - clean
    factor = {"acceleration": -1.0, "displacement": -(found.frequency**2), "velocity": -found.frequency}
    return np.asarray(factor[channel] * error)


def force_map(prepared: PreparedDecay, force: Array) -> ForceMap:
    """Sort a force along the measured motion, shape (n,), by amplitude and phase of the cycle."""
    motion = prepared.motion
    used = moving(motion) & np.isfinite(force)
    size = np.hypot(motion.displacement, motion.velocity / prepared.frequency)
    angle = np.mod(np.arctan2(-motion.velocity / prepared.frequency, motion.displacement), 2.0 * np.pi)
    amplitude = np.linspace(float(size[used].min()), float(size[used].max()) * (1.0 + 1e-9), RINGS + 1)
    phase = np.linspace(0.0, 2.0 * np.pi, ANGLES + 1)
    ring = np.clip(np.digitize(size, amplitude) - 1, 0, RINGS - 1)
    sector = np.clip(np.digitize(angle, phase) - 1, 0, ANGLES - 1)
    outer = ring >= RINGS // 2
    return ForceMap(
        amplitude,
        phase,
        _means(ring * ANGLES + sector, force, used, RINGS * ANGLES).reshape(RINGS, ANGLES),
        _means(sector, force, used & outer, ANGLES),
        _means(sector, force, used & ~outer, ANGLES),
    )


def _means(place: NDArray[np.signedinteger[Any]], force: Array, used: Mask, bins: int) -> Array:
    count = np.bincount(place[used], minlength=bins)
    total = np.bincount(place[used], weights=force[used], minlength=bins)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan)
