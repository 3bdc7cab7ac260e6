"""A force that is the whole spring, as gravity on a pendulum: it has the spring's strength, no constant of its own.

A free run determines it by the change of the frequency alone, a hundred times worse than the spring. Where the two agree,
one number serves for both.
"""

from dataclasses import replace

import numpy as np

from identify.fitting.fit import Fit, fit_at
from identify.fitting.levenberg_marquardt import minimise_fully

_AGREES = 3.0
"""Standard errors within which a strength is that of the spring."""

_SURE = 0.02
"""Error of a strength, as a share of the spring, below which it says something by itself: the calibration of an angle."""

_ROUNDS = 3


def as_the_whole_spring(stated: Fit, found: Fit) -> Fit:
    """Give the spring and a force that may be all of it one strength, where the `stated` errors allow that.

    Its covariance is that under this condition. The same fit where no such force is, or where it differs from the spring.
    """
    pair = _pair(stated)
    if pair is None:
        return found
    force, spring = pair
    problem, theta = found.problem, found.theta.copy()
    held = np.arange(len(theta)) == force
    for _ in range(_ROUNDS):  # the spring hardly moves
        theta[force] = theta[spring]
        theta = minimise_fully(problem, theta, held=held).theta
    theta[force] = theta[spring]
    tied = fit_at(problem, theta)
    apart = tied.covariance[:, force] - tied.covariance[:, spring]
    variance = max(float(apart[force] - apart[spring]), 1e-300)
    covariance = tied.covariance - np.outer(apart, apart) / variance
    name = found.unknowns[force].name
    own = {name: replace(tied.values[name], std=tied.values[found.unknowns[spring].name].std)}
    return replace(tied, converged=found.converged, covariance=covariance, values=tied.values | own)


def _pair(stated: Fit) -> tuple[int, int] | None:
    """Find the places of the spring and of a force that may be all of it, itself uncertain; None without one."""
    for term in stated.model.forces:
        part = term.force.may_be_all_of
        spring = None if part is None else stated.model.linear_strength(part)
        if spring is None:
            continue
        own, whole = stated.values[str(term.strength)], stated.values[str(spring)]
        if own.std > _SURE * whole.value and abs(own.value - whole.value) < _AGREES * own.std:
            return stated.names.index(str(term.strength)), stated.names.index(str(spring))
    return None
