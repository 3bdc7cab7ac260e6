"""Effects of damping: smooth forces that depend on the velocity, and dry friction, a level that acts against it."""

from math import exp

from identify.effects.effect import Parameter, shares_of
from identify.effects.force_effect import ForceEffect, LinearPart

VISCOUS_DAMPING = ForceEffect(
    name="viscous_damping",
    title="viscous damping",
    equation="mu_1 v",
    parameters=(Parameter("mu_1", "1/s", "viscous damping per unit mass", 0.0),),
    force=lambda t, u, v, z, p: p[0] * v,
    linear_part=LinearPart.DAMPING,
    symptom="exponential decay",
    confirming_test="the decrement is the same at every amplitude",
)

QUADRATIC_DAMPING = ForceEffect(
    name="quadratic_damping",
    title="drag (quadratic damping)",
    equation="c2 v |v|",
    parameters=(Parameter("c2", "1/m", "drag per unit mass", 0.0),),
    force=lambda t, u, v, z, p: p[0] * v * abs(v),
    shows_detection_limit=True,
    symptom="the decrement grows in proportion to the amplitude",
    confirming_test="release from twice the amplitude: the extra decrement doubles",
    confusable_with=("cubic_damping", "position_dependent_damping", "fading_damping"),
)

CUBIC_DAMPING = ForceEffect(
    rarity=1,
    name="cubic_damping",
    title="cubic damping",
    equation="c3 v^3",
    parameters=(Parameter("c3", "s/m^2", "cubic damping per unit mass", 0.0),),
    force=lambda t, u, v, z, p: p[0] * v * v * v,
    symptom="the decrement grows with the square of the amplitude, third harmonic in phase with v",
    confirming_test="release from twice the amplitude: the extra decrement grows fourfold",
    confusable_with=("quadratic_damping", "position_dependent_damping"),
)

POSITION_DEPENDENT_DAMPING = ForceEffect(
    rarity=1,
    name="position_dependent_damping",
    title="damping that grows away from the middle",
    equation="c12 u^2 v",
    parameters=(Parameter("c12", "1/(m^2 s)", "damping per squared displacement, per unit mass", 0.0),),
    force=lambda t, u, v, z, p: p[0] * u * u * v,
    symptom="the decrement grows with the square of the amplitude, opposite third harmonic",
    confirming_test="the section of the restoring force at u = 0 stays straight",
    confusable_with=("cubic_damping", "quadratic_damping"),
)

COULOMB_FRICTION = ForceEffect(
    name="coulomb_friction",
    title="dry (Coulomb) friction",
    equation="mu_0 sgn v",
    parameters=(Parameter("mu_0", "m/s^2", "friction force per unit mass", 0.0),),
    friction=lambda t, u, v, z, p: p[0],
    linear_part=LinearPart.DRY_FRICTION,
    symptom="straight-line decay that stops off zero",
    confirming_test="the mass comes to rest off the spring's zero, within mu_0/k of it",
)

STRIBECK_FRICTION = ForceEffect(
    name="stribeck_friction",
    title="friction that rises at low speed (Stribeck)",
    equation="dmu exp(-(v/vs)^2) sgn v",
    parameters=(
        Parameter("dmu", "m/s^2", "extra friction at rest per unit mass", 0.0),
        Parameter("vs", "m/s", "speed at which it has fallen to 1/e", 0.0),
    ),
    friction=lambda t, u, v, z, p: p[0] * exp(-(v / p[1]) * (v / p[1])),
    starts=shares_of("speed", 0.08, 0.2, 0.4),
    reach=shares_of(
        "speed", 0.002, 0.005, 0.01, 0.02, 0.035, 0.06, 0.1, 0.16, 0.25, 0.4, 0.5, 0.65, 1.0, 1.6
    ),
    symptom="extra loss near the end of the decay",
    confirming_test="a release from a quarter of the amplitude decays faster than the model says",
    confusable_with=("coulomb_friction", "quadratic_damping", "position_dependent_friction"),
)

POSITION_DEPENDENT_FRICTION = ForceEffect(
    name="position_dependent_friction",
    title="guides that bind away from the middle",
    equation="slope |u| sgn v",
    parameters=(Parameter("slope", "1/s^2", "growth of the friction with displacement, per unit mass", 0.0),),
    friction=lambda t, u, v, z, p: p[0] * abs(u),
    symptom="loss per cycle like viscous damping, but the force jumps at every reversal in proportion to amplitude",
    confirming_test="the jump of the acceleration at the reversals grows with the amplitude",
    confusable_with=("viscous_damping", "hysteresis", "fading_friction"),
)
