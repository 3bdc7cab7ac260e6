"""Effects of dry friction: a level that acts against the velocity, and holds the mass at rest."""

from math import exp, inf

from identify.effects.compiled import force_function
from identify.effects.effect import Parameter, Scales
from identify.effects.force_effect import ForceEffect, LinearPart


@force_function
def _coulomb(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0]


COULOMB_FRICTION = ForceEffect(
    name="coulomb_friction",
    title="dry (Coulomb) friction",
    equation="mu_0 sgn v",
    parameters=(Parameter("mu_0", "m/s^2", "friction force per unit mass", 0.0, inf),),
    friction=_coulomb,
    linear_part=LinearPart.DRY_FRICTION,
    symptom="straight-line decay that stops off zero",
    confirming_test="the mass comes to rest off the spring's zero, within mu_0/k of it",
)


@force_function
def _stribeck(t, u, v, z, p):  # type: ignore[no-untyped-def]
    ratio = v / p[1]
    return p[0] * exp(-ratio * ratio)


_SPEEDS = (0.002, 0.005, 0.01, 0.02, 0.035, 0.06, 0.1, 0.16, 0.25, 0.4, 0.5, 0.65, 1.0, 1.6)


def _speed_starts(scales: Scales) -> tuple[tuple[float, ...], ...]:
    return tuple((share * scales.speed,) for share in (0.08, 0.2, 0.4))


STRIBECK_FRICTION = ForceEffect(
    name="stribeck_friction",
    title="friction that rises at low speed (Stribeck)",
    equation="dmu exp(-(v/vs)^2) sgn v",
    parameters=(
        Parameter("dmu", "m/s^2", "extra friction at rest per unit mass", 0.0, inf),
        Parameter("vs", "m/s", "speed at which it has fallen to 1/e", 0.0, inf),
    ),
    friction=_stribeck,
    starts=_speed_starts,
    reach=lambda scales: tuple((share * scales.speed,) for share in _SPEEDS),
    symptom="extra loss near the end of the decay",
    confirming_test="a release from a quarter of the amplitude decays faster than the model says",
    confusable_with=("coulomb_friction", "quadratic_damping", "position_dependent_friction"),
)


@force_function
def _position_dependent(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return p[0] * abs(u)


POSITION_DEPENDENT_FRICTION = ForceEffect(
    name="position_dependent_friction",
    title="guides that bind away from the middle",
    equation="slope |u| sgn v",
    parameters=(
        Parameter("slope", "1/s^2", "growth of the friction with displacement, per unit mass", 0.0, inf),
    ),
    friction=_position_dependent,
    symptom="loss per cycle like viscous damping, but the force jumps at every reversal in proportion to amplitude",
    confirming_test="the jump of the acceleration at the reversals grows with the amplitude",
    confusable_with=("viscous_damping", "hysteresis"),
)
