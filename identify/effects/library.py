"""The library: every effect and every sensor's fault, in one tuple."""

from identify.effects import contact, damping, joint, memory, sensors, stiffness, time
from identify.effects.effect import Effect
from identify.effects.families import FAMILY_OF
from identify.effects.force_effect import ForceEffect
from identify.effects.sensor_fault import SensorFault

BASE: tuple[ForceEffect, ...] = (
    stiffness.LINEAR_STIFFNESS,
    damping.COULOMB_FRICTION,
    damping.VISCOUS_DAMPING,
)

DAMPING_BY_ORDER: tuple[ForceEffect, ...] = (
    damping.COULOMB_FRICTION,
    damping.VISCOUS_DAMPING,
    damping.QUADRATIC_DAMPING,
    damping.CUBIC_DAMPING,
)
"""The damping |v|^n sgn(v) of each order n that has a name, from n = 0 up."""

STIFFNESS_BY_ORDER: dict[int, ForceEffect] = {
    1: stiffness.LINEAR_STIFFNESS,
    2: stiffness.QUADRATIC_STIFFNESS,
    3: stiffness.CUBIC_STIFFNESS,
    5: stiffness.QUINTIC_STIFFNESS,
}
"""The spring u^n of each order n that has a name."""

CORRECTED: dict[str, SensorFault] = {"gain": sensors.CHANNEL_GAIN, "lost readings": sensors.DROPOUTS}
"""The faults that are judged by what every fit corrected."""

LIBRARY: tuple[Effect, ...] = (
    *BASE,
    damping.QUADRATIC_DAMPING,
    damping.CUBIC_DAMPING,
    damping.POSITION_DEPENDENT_DAMPING,
    damping.STRIBECK_FRICTION,
    damping.POSITION_DEPENDENT_FRICTION,
    stiffness.CUBIC_STIFFNESS,
    stiffness.QUADRATIC_STIFFNESS,
    stiffness.SIGNED_QUADRATIC_STIFFNESS,
    stiffness.QUINTIC_STIFFNESS,
    stiffness.PENDULUM_STIFFNESS,
    contact.END_STOP,
    contact.IMPACT,
    contact.FREEPLAY,
    stiffness.BILINEAR_STIFFNESS,
    joint.DAHL_FRICTION,
    joint.HYSTERESIS,
    memory.MAXWELL_ELEMENT,
    memory.SECOND_MASS,
    time.TIME_VARYING_STIFFNESS,
    time.SETTLING_STIFFNESS,
    time.FADING_FRICTION,
    time.FADING_DAMPING,
    time.HARMONIC_FORCING,
    sensors.CHANNEL_LAG,
    sensors.CHANNEL_GAIN,
    sensors.OFFSET_DRIFT,
    sensors.CLIPPING,
    sensors.SENSOR_NONLINEARITY,
    sensors.AC_COUPLING,
    sensors.SENSOR_BANDWIDTH,
    sensors.MAINS_HUM,
    sensors.DROPOUTS,
)


NAMED: tuple[Effect, ...] = (*LIBRARY, *FAMILY_OF)
"""All that a model may have: the library, which a diagnosis tries, and the laws between its effects that are claimed."""


def find_effect(name: str, library: tuple[Effect, ...] = ()) -> Effect:
    """Return the effect of that name, as "stribeck_friction" or "Stribeck friction"; KeyError when there is none.

    It is one of `NAMED`, or of a `library` of one's own.
    """
    known = {effect.name.lower(): effect for effect in (*NAMED, *library)}
    wanted = "_".join(name.lower().split())
    if wanted not in known:
        raise KeyError(f"no effect is called '{name}'; there are: {', '.join(known)}")
    return known[wanted]
