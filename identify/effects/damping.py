"""Effects of damping: smooth forces that depend on the velocity."""

from identify.effects.effect import Parameter
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
    confusable_with=("cubic_damping", "position_dependent_damping"),
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
