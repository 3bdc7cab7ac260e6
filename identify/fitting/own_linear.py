"""A linear spring and damper for each release, near those of all releases.

On a rig neither is quite the same from one release to the next: brakes are set, air, bearings and temperature change. So
both may differ, within priors. A prior counts in units of what a model leaves, not of the noise: else a wrong model that
leaves a thousand times the noise could bend them at will. What was changed on purpose is each release's own.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.effects.force_effect import LinearPart
from identify.fitting.parameter_layout import OWN_STIFFNESS, Unknown
from identify.fitting.problem import Problem
from identify.model.model import Model
from identify.model.parameter_id import nuisance
from identify.preprocessing.fit_window import FitWindow, OwnLinear, windows_by_release
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.priors import DAMPING_VARIES, STIFFNESS_VARIES
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import running_amplitude

VARIES = ("stiffness", "damping", "inertia")
"""What may be changed on purpose between releases of one rig."""

_ANYTHING = 100.0
"""Standard deviation of a spring (relative) or a damper (mean losses) that was changed on purpose: as good as unknown."""

_BY_FREQUENCY = 0.05
"""Relative error of a ratio of inertias that is taken from the frequencies of releases of unlike amplitudes."""

_AS_GOOD = 2.0
"""Ratio of two weights up to which one serves for the other: a prior is known to no more."""


def with_own_linear(windows: Sequence[FitWindow], frequency: float) -> tuple[FitWindow, ...]:
    """Allow each release a spring and a damper of its own; the motion is at `frequency` (rad/s)."""
    losses = [
        np.mean([_loss(windows[i], frequency) for i in places])
        for places in windows_by_release(windows).values()
    ]
    spring, damper = shares_of(windows[0].varies)
    own = OwnLinear(spring * frequency**2, damper * float(np.mean(losses)))
    return tuple(window.with_(own_linear=own) for window in windows)


def shares_of(varies: frozenset[str]) -> tuple[float, float]:
    """Return the range of spring (relative) and damper (mean losses) where some things were changed on purpose."""
    spring = _BY_FREQUENCY if "inertia" in varies else STIFFNESS_VARIES
    return (
        _ANYTHING if "stiffness" in varies else spring,
        _ANYTHING if "damping" in varies or {"stiffness", "inertia"} <= varies else DAMPING_VARIES,
    )


def changed_on_purpose(
    decays: Sequence[PreparedDecay], varies: frozenset[str], spring: float = 0.0
) -> tuple[PreparedDecay, ...]:
    """Give each release its own values of what was changed on purpose between them (some of VARIES).

    Where only the inertia was changed, its ratio is that of the squared frequencies, and all forces per unit of inertia
    follow it; `spring` is the stiffness (1/s^2) that these are shares of, the first release's unless given. Where the
    stiffness was changed too, frequencies do not tell the inertia: spring and damper are each one's own then.
    """
    if not varies or not decays:
        return tuple(decays)
    spring = spring or decays[0].frequency ** 2
    only_inertia = "inertia" in varies and "stiffness" not in varies
    windows = [
        prepared.window.with_(
            varies=varies,
            lightness=prepared.frequency**2 / spring if only_inertia else 1.0,
            release=place,
        )
        for place, prepared in enumerate(decays)
    ]
    pairs = zip(decays, with_own_linear(windows, decays[0].frequency), strict=True)
    return tuple(replace(prepared, window=window) for prepared, window in pairs)


def own_springs(
    decays: Sequence[PreparedDecay], model: Model, start: Mapping[str, float]
) -> dict[str, float]:
    """Estimate starting values of the releases' own springs, where springs were changed, by unknown's name."""
    strength = model.linear_strength(LinearPart.STIFFNESS)
    groups = windows_by_release([prepared.window for prepared in decays])
    if strength is None:
        return {}
    return {
        str(nuisance(OWN_STIFFNESS, number, len(groups))): decays[places[0]].frequency ** 2
        - start[str(strength)]
        for number, places in enumerate(groups.values())
        if "stiffness" in decays[places[0]].window.varies
    }


def without_own_linear(windows: Sequence[FitWindow]) -> tuple[FitWindow, ...]:
    """Make releases share spring and damper, unless these were changed on purpose."""
    return tuple(w if w.own_linear is None or w.varies else w.with_(own_linear=None) for w in windows)


def weighed(problem: Problem, theta: Array) -> tuple[FitWindow, ...]:
    """Scale the priors of a problem's windows to the residual at `theta`; return the same windows if they fit already.

    The weight is 1 where the model is right; what it leaves beyond the noise repeats in every reading of a half-cycle.
    """
    if not problem.expected:
        return problem.windows
    off = np.concatenate([motion.misfit for motion in problem.motions(theta)])
    if not np.isfinite(off).all():
        return problem.windows
    half_cycle = np.pi / problem.frequency * problem.windows[0].rate
    weight = 1.0 + max(float(np.mean(off**2)) - 1.0, 0.0) * half_cycle
    return tuple(_with_weight(window, weight) for window in problem.windows)


def centred(problem: Problem, theta: Array, covariance: Array) -> tuple[Array, Array, Array]:
    """Set the shared spring and damper to the means of those of the releases; return unknowns (p,) and covariance.

    The readings do not tell a shared part from the mean of the releases' own; it is that of these releases then. By how
    much it may differ for others, from the spread of these, is the third: a standard error to be added to that from the
    noise (p,), 0 of all other unknowns.
    """
    turned, spread = np.eye(len(theta)), np.zeros(len(theta))
    theta = theta.copy()
    for j in problem.expected:
        theta[j] = problem.deviation(theta, j)
    for shared, own in problem.deviations.items():
        turned[shared, own] += 1.0 / len(own)
        turned[np.ix_(own, own)] -= 1.0 / len(own)
        if len(own) > 1:
            spread[shared] = np.std(theta[own], ddof=1) / np.sqrt(len(own))
    return turned @ theta, turned @ covariance @ turned.T, spread


def percent_off(window: FitWindow, unknown: Unknown, off: float) -> float:
    """Express the deviation `off` of a release in % of its squared frequency or its mean loss."""
    spring, damper = shares_of(window.varies)
    return 100.0 * (spring if unknown.id.parameter == OWN_STIFFNESS else damper) * off / unknown.size


def _with_weight(window: FitWindow, weight: float) -> FitWindow:
    own = window.own_linear
    if own is None or 1.0 / _AS_GOOD <= own.weight / weight <= _AS_GOOD:
        return window
    return window.with_(own_linear=replace(own, weight=weight))


def _loss(window: FitWindow, frequency: float) -> float:
    """Return the mean loss of a window as an equivalent viscous damping, 1/s: -2 d(ln A)/dt over all cycles."""
    channel = window.channels[0]
    used, values = window.used[channel], window.readings[channel]
    period = max(int(2.0 * np.pi / frequency * window.rate), 2)
    if len(values) <= 3 * period or not used.any():
        return 0.0
    running = running_amplitude(bridge(values, used), period)
    first, last = float(running[period]), float(running[-period - 1])
    if not 0.0 < last < first:
        return 0.0
    return 2.0 * math.log(first / last) * window.rate / (len(values) - 2 * period)
