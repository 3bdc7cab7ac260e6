"""Effects of the spring: forces that depend on the displacement."""

from math import sin

from identify.effects.effect import Parameter, Scales
from identify.effects.force_effect import ForceEffect, LinearPart

LINEAR_STIFFNESS = ForceEffect(
    name="linear_stiffness",
    title="linear spring",
    equation="k u",
    parameters=(Parameter("k", "1/s^2", "stiffness per unit mass", 0.0),),
    force=lambda t, u, v, z, p: p[0] * u,
    linear_part=LinearPart.STIFFNESS,
    symptom="one frequency at every amplitude",
    confirming_test="the frequency stays the same when the release amplitude is changed",
)

CUBIC_STIFFNESS = ForceEffect(
    name="cubic_stiffness",
    title="hardening or softening spring (Duffing)",
    equation="k3 u^3",
    parameters=(Parameter("k3", "1/(m^2 s^2)", "cubic stiffness per unit mass"),),
    force=lambda t, u, v, z, p: p[0] * u * u * u,
    shows_detection_limit=True,
    symptom="the frequency moves with the square of the amplitude, alike in both directions",
    confirming_test="release from twice the amplitude: the frequency shift grows fourfold",
    confusable_with=(
        "pendulum_stiffness",
        "quintic_stiffness",
        "end_stop",
        "time_varying_stiffness",
        "freeplay",
    ),
)

QUADRATIC_STIFFNESS = ForceEffect(
    name="quadratic_stiffness",
    title="one-sided hardening spring",
    equation="k2 u^2",
    parameters=(Parameter("k2", "1/(m s^2)", "quadratic stiffness per unit mass"),),
    force=lambda t, u, v, z, p: p[0] * u * u,
    symptom="the mean position moves with the square of the amplitude; second harmonic",
    confirming_test="release from the opposite side: the shift of the mean keeps its sign",
    confusable_with=("bilinear_stiffness", "offset_drift"),
)

SIGNED_QUADRATIC_STIFFNESS = ForceEffect(
    rarity=1,
    name="signed_quadratic_stiffness",
    title="spring that hardens in proportion to its deflection",
    equation="k2a u |u|",
    parameters=(Parameter("k2a", "1/(m s^2)", "growth of the stiffness with the deflection, per unit mass"),),
    force=lambda t, u, v, z, p: p[0] * u * abs(u),
    symptom="the frequency moves in proportion to the amplitude, alike in both directions",
    confirming_test="release from twice the amplitude: the frequency shift doubles",
    confusable_with=("cubic_stiffness", "freeplay", "end_stop"),
)

QUINTIC_STIFFNESS = ForceEffect(
    rarity=1,
    name="quintic_stiffness",
    title="sharply hardening spring",
    equation="k5 u^5",
    parameters=(Parameter("k5", "1/(m^4 s^2)", "quintic stiffness per unit mass"),),
    force=lambda t, u, v, z, p: p[0] * u**5,
    symptom="the frequency moves with the fourth power of the amplitude",
    confirming_test="releases from two amplitudes: the shift grows as the fourth power",
    confusable_with=("pendulum_stiffness", "cubic_stiffness", "end_stop"),
)

BILINEAR_STIFFNESS = ForceEffect(
    name="bilinear_stiffness",
    title="spring stiffer on one side",
    equation="kb |u| / 2",
    parameters=(
        Parameter("kb", "1/s^2", "stiffness on the positive side less that on the other, per unit mass"),
    ),
    force=lambda t, u, v, z, p: 0.5 * p[0] * abs(u),
    symptom="one half-cycle shorter than the other at every amplitude; even harmonics",
    confirming_test="the half-cycles keep their difference at small amplitude",
    confusable_with=("quadratic_stiffness", "end_stop"),
    nonsmooth=True,
)


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
