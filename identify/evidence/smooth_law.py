"""A smooth law without a name: how much of a misfit some law that the library does not hold explains, by its evidence.

A law may be any smooth function of displacement, of velocity or of time, as spring, damper or friction: a series of Legendre
polynomials whose coefficients are normal, those of higher orders smaller (a Gaussian process; Rasmussen and Williams, 2006).
The misfit is taken for linear in it, as in a random walk, which is part of every hypothesis: what a walk explains is no law.
"""

import numpy as np
from numpy.polynomial import legendre

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
from identify.fitting.random_walk import RandomWalk, changes_by, explained_by
from identify.priors import NAMELESS_IS, SIZES

_ORDERS = 8
"""Orders of a series: of the last one a law bends seven times from end to end."""


def smooth_law_beside(found: Fit, walk: RandomWalk) -> float:
    """Return the evidence (nats) for a smooth law beside a fit and a walk of its spring and damper, against the walk alone.

    The coordinates are as probable as one another; a law's size is not known, and a large one is rarer.
    """
    problem = Problem(found.model, found.windows, found.frequency)
    residual, jacobian = linearise(problem, found.theta)
    tangent = jacobian.tangent(np.diag(jacobian.normal()) > 0.0)
    misfit = tangent.free(residual)
    known, _ = explained_by(walk.follows.T @ walk.follows, walk.follows.T @ misfit)
    rarer = -NAMELESS_IS * np.arange(len(SIZES) - 1)
    rarer -= np.logaddexp.reduce(rarer)
    each = []
    for law in _laws(problem, found.theta):
        columns = np.column_stack([walk.follows, tangent.free(law)])
        products, along = columns.T @ columns, columns.T @ misfit
        for size, prior in zip(SIZES[1:], rarer, strict=True):
            scale = np.ones(len(along))
            scale[walk.follows.shape[1] :] = size / np.arange(1, _ORDERS + 1)
            gain, _ = explained_by(products * np.outer(scale, scale), along * scale)
            each.append(gain - known + prior)
    return float(np.logaddexp.reduce(each) - np.log(len(each) / len(rarer)))


def _laws(problem: Problem, theta: Array) -> list[Array]:
    """Return how the misfit changes with the polynomials of each law, each as large as the spring at the largest amplitude.

    (readings, orders) each; one law holds for all releases.
    """
    motions = [problem.respond(theta, i) for i in range(len(problem.windows))]
    far = max(float(np.max(np.abs(motion.displacement))) for motion in motions)
    fast = max(float(np.max(np.abs(motion.velocity))) for motion in motions)
    last = max(float(window.clock[-1]) for window in problem.windows)
    windows = []
    for i, (window, motion) in enumerate(zip(problem.windows, motions, strict=True)):
        u, v, t = motion.displacement / far, motion.velocity / fast, 2.0 * window.clock / last - 1.0
        way = np.sign(v)
        forces = [
            far * problem.frequency**2 * factor * series
            for place, factor in (
                (u, np.ones_like(u)),
                (v, np.ones_like(v)),
                (u, way),
                (2.0 * np.abs(v) - 1.0, way),
                (u, v),
                (t, u),
                (t, v),
                (t, way),
            )
            for series in legendre.legvander(np.clip(place, -1.0, 1.0), _ORDERS).T[1:]
        ]
        windows.append(np.column_stack(changes_by(problem, theta, i, forces)))
    off = np.zeros((len(problem.expected), windows[0].shape[1]))
    return np.split(np.concatenate([*windows, off]), windows[0].shape[1] // _ORDERS, axis=1)
