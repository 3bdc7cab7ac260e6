"""A pendulum: gravity's restoring moment grows with the sine of the angle, and falls behind a linear spring's."""

from math import sin

from identify.effects.effect import Parameter, Scales
from identify.effects.force_effect import ForceEffect, LinearPart

_LEAST, _MOST = 0.3, 1.5
"""Shares of the whole stiffness between which a softening is called gravity's: beyond, a spring would have to push the
pendulum over, and a cubic spring says the same."""


def _is_gravity(values: dict[str, float], scales: Scales) -> bool:
    """Check whether gravity is a share of the whole stiffness about rest that it can have.

    A swing of amplitude A (rad) has less stiffness than there is about rest: gravity alone has 2 J1(A)/A of it, the first
    Fourier coefficient of sin(A cos x) over A, which is a half at 130 degrees and a quarter at 160.
    """
    from scipy.special import j1

    g, seen = values["g"], scales.frequency**2
    lost = 1.0 - 2.0 * float(j1(scales.amplitude)) / scales.amplitude
    return _LEAST * seen < g < _MOST * (seen + max(lost, 0.0) * g)


PENDULUM_STIFFNESS = ForceEffect(
    name="pendulum_stiffness",
    title="gravity on a pendulum",
    equation="g (sin u - u)",
    parameters=(
        Parameter("g", "1/s^2", "moment of gravity per unit inertia, the part of k that is no spring"),
    ),
    force=lambda t, u, v, z, p: p[0] * (sin(u) - u),
    units=("rad",),
    may_be_all_of=LinearPart.STIFFNESS,
    plausible=_is_gravity,
    symptom="the frequency falls with the square of the angle, as 1 - angle^2/16 where there is no other spring",
    confirming_test="turn the axis vertical, so that gravity has no moment: the frequency is the same at every angle",
    confusable_with=("cubic_stiffness", "quintic_stiffness"),
)
