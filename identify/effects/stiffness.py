"""Effects of the spring: forces that depend on the displacement."""

from math import inf

from identify.effects.compiled import force_function
from identify.effects.effect import Parameter, Scales
from identify.effects.force_effect import ForceEffect, LinearPart


@force_function
def _linear(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * u


LINEAR_STIFFNESS = ForceEffect(
    name="linear_stiffness",
    title="linear spring",
    equation="k u",
    parameters=(Parameter("k", "1/s^2", "stiffness per unit mass", 0.0, inf),),
    force=_linear,
    linear_part=LinearPart.STIFFNESS,
    symptom="one frequency at every amplitude",
    confirming_test="the frequency stays the same when the release amplitude is changed",
)


@force_function
def _cubic(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * u * u * u


CUBIC_STIFFNESS = ForceEffect(
    name="cubic_stiffness",
    title="hardening or softening spring (Duffing)",
    equation="k3 u^3",
    parameters=(Parameter("k3", "1/(m^2 s^2)", "cubic stiffness per unit mass"),),
    force=_cubic,
    shows_detection_limit=True,
    symptom="the frequency moves with the square of the amplitude, alike in both directions",
    confirming_test="release from twice the amplitude: the frequency shift grows fourfold",
    confusable_with=("quintic_stiffness", "end_stop", "time_varying_stiffness", "freeplay"),
)


@force_function
def _quadratic(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * u * u


QUADRATIC_STIFFNESS = ForceEffect(
    name="quadratic_stiffness",
    title="one-sided hardening spring",
    equation="k2 u^2",
    parameters=(Parameter("k2", "1/(m s^2)", "quadratic stiffness per unit mass"),),
    force=_quadratic,
    symptom="the mean position moves with the square of the amplitude; second harmonic",
    confirming_test="release from the opposite side: the shift of the mean keeps its sign",
    confusable_with=("bilinear_stiffness", "offset_drift"),
)


@force_function
def _signed_quadratic(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * u * abs(u)


SIGNED_QUADRATIC_STIFFNESS = ForceEffect(
    rarity=1,
    name="signed_quadratic_stiffness",
    title="spring that hardens in proportion to its deflection",
    equation="k2a u |u|",
    parameters=(Parameter("k2a", "1/(m s^2)", "growth of the stiffness with the deflection, per unit mass"),),
    force=_signed_quadratic,
    symptom="the frequency moves in proportion to the amplitude, alike in both directions",
    confirming_test="release from twice the amplitude: the frequency shift doubles",
    confusable_with=("cubic_stiffness", "freeplay", "end_stop"),
)


@force_function
def _quintic(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * u**5


QUINTIC_STIFFNESS = ForceEffect(
    rarity=1,
    name="quintic_stiffness",
    title="sharply hardening spring",
    equation="k5 u^5",
    parameters=(Parameter("k5", "1/(m^4 s^2)", "quintic stiffness per unit mass"),),
    force=_quintic,
    symptom="the frequency moves with the fourth power of the amplitude",
    confirming_test="releases from two amplitudes: the shift grows as the fourth power",
    confusable_with=("cubic_stiffness", "end_stop"),
)


@force_function
def _end_stop(t, u, v, z, p):  # type: ignore[no-untyped-def]
    force = 0.0
    if p[2] >= 0.0 and u > p[1]:
        force = p[0] * (u - p[1])
    if p[2] <= 0.0 and u < -p[1]:
        force = p[0] * (u + p[1])
    return force


_PLAY_SHARE = 0.35
"""A gap below this share of the amplitude is called play, one above it an end stop: the forces are the same."""


_GAPS = (0.03, 0.08, 0.16, 0.26, 0.36, 0.46, 0.55, 0.63, 0.7, 0.76, 0.82, 0.87, 0.91, 0.95)
"""Gaps over the amplitude that a fit of a stop may reach: those of play too."""


def _gap_starts(scales: Scales) -> tuple[tuple[float, ...], ...]:
    return tuple((share * scales.amplitude,) for share in (0.35, 0.6, 0.8))


END_STOP = ForceEffect(
    name="end_stop",
    title="end stop",
    equation="ks max(u - gap, 0) on side +1, -1 or both (0)",
    parameters=(
        Parameter("ks", "1/s^2", "stiffness of the stop per unit mass", 0.0, inf),
        Parameter("gap", "m", "displacement at which it is met", 0.0, inf),
        Parameter("side", "1", "+1, -1, or 0 for both"),
    ),
    force=_end_stop,
    starts=_gap_starts,
    reach=lambda scales: tuple((share * scales.amplitude,) for share in _GAPS),
    variants=({"side": 1.0}, {"side": -1.0}, {"side": 0.0}),
    plausible=lambda values, scales: values["gap"] > _PLAY_SHARE * scales.amplitude,
    symptom="nothing happens below the gap; above it the force has a kink",
    confirming_test="release from just below the gap: the effect is gone",
    confusable_with=("freeplay", "cubic_stiffness", "quintic_stiffness", "bilinear_stiffness", "clipping"),
    nonsmooth=True,
)


@force_function
def _freeplay(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return -p[0] * min(max(u, -p[1]), p[1])


_PLAYS = (0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6, 0.85)


def _play_starts(scales: Scales) -> tuple[tuple[float, ...], ...]:
    return tuple((share * scales.amplitude,) for share in (0.06, 0.14, 0.3))


FREEPLAY = ForceEffect(
    name="freeplay",
    title="play in a joint",
    equation="-kf clip(u, -gap, gap)",
    parameters=(
        Parameter("kf", "1/s^2", "stiffness missing inside the play, per unit mass", 0.0, inf),
        Parameter("gap", "m", "half of the play", 0.0, inf),
    ),
    force=_freeplay,
    starts=_play_starts,
    reach=lambda scales: tuple((share * scales.amplitude,) for share in _PLAYS),
    plausible=lambda values, scales: values["gap"] <= _PLAY_SHARE * scales.amplitude,
    symptom="softer at small amplitude",
    confirming_test="release from a few times the gap: the frequency falls further",
    confusable_with=("end_stop", "cubic_stiffness", "time_varying_stiffness", "hysteresis"),
    nonsmooth=True,
)


@force_function
def _bilinear(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return 0.5 * p[0] * abs(u)


BILINEAR_STIFFNESS = ForceEffect(
    name="bilinear_stiffness",
    title="spring stiffer on one side",
    equation="kb |u| / 2",
    parameters=(
        Parameter("kb", "1/s^2", "stiffness on the positive side less that on the other, per unit mass"),
    ),
    force=_bilinear,
    symptom="one half-cycle shorter than the other at every amplitude; even harmonics",
    confirming_test="the half-cycles keep their difference at small amplitude",
    confusable_with=("quadratic_stiffness", "end_stop"),
    nonsmooth=True,
)
