"""Equation error: forces regressed on the measured motion. Quick, and good enough to start a fit from.

At every sample the restoring force, less any recorded one, is the sum of the forces at the measured displacement and
velocity. Internal states are driven along the measured motion. Samples of small speed are left out: the sign of a noisy
velocity is noise.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.preprocessing.motion import Motion


@dataclass(frozen=True, eq=False)
class Regression:
    """Linear strengths (terms,), in the order of the terms, a `constant` (m/s^2), and what they leave.

    `residual` (n,) is that of the restoring force at every sample, `rss` its sum of squares over the samples used.
    """

    strengths: Array
    constant: float
    residual: Array
    rss: float


def moving(motion: Motion, *, sigmas: float = 3.0) -> Mask:
    """Mark the samples where the velocity surely differs from zero and keeps its sign nearby, shape (n,)."""
    speed = np.abs(motion.velocity)
    fast = speed > max(sigmas * motion.noise_velocity, 0.02 * float(speed.max(initial=0.0)))
    steady = fast.copy()
    steady[1:] &= fast[:-1]
    steady[:-1] &= fast[1:]
    return motion.valid & steady


def regress(restoring: Array, columns: Array, used: Mask, noise: float = 1.0) -> Regression:
    """Least squares of the measured restoring force per unit mass (n,) on force columns (n, terms) and a constant."""
    design = np.column_stack([columns, np.ones(len(columns))])
    if not np.isfinite(design[used]).all():  # a state that diverged
        return Regression(np.zeros(columns.shape[1]), 0.0, restoring, np.inf)
    size = np.linalg.norm(design[used], axis=0)
    size[size == 0.0] = 1.0
    solution = np.linalg.lstsq(design[used] / size, restoring[used], rcond=1e-12)[0] / size
    residual = restoring - design @ solution
    rss = float(np.sum(residual[used] ** 2)) / noise**2
    return Regression(solution[:-1], float(solution[-1]), residual, rss)
