"""The library: every effect and every sensor's fault, in one tuple."""

from identify.effects.contact import END_STOP, FREEPLAY, IMPACT
from identify.effects.damping import (
    CUBIC_DAMPING,
    POSITION_DEPENDENT_DAMPING,
    QUADRATIC_DAMPING,
    VISCOUS_DAMPING,
)
from identify.effects.effect import Effect
from identify.effects.force_effect import ForceEffect
from identify.effects.friction import COULOMB_FRICTION, POSITION_DEPENDENT_FRICTION, STRIBECK_FRICTION
from identify.effects.joint import DAHL_FRICTION, HYSTERESIS
from identify.effects.memory import MAXWELL_ELEMENT, SECOND_MASS
from identify.effects.pendulum import PENDULUM_STIFFNESS
from identify.effects.sensor_fault import Allowance, SensorFault
from identify.effects.sensors import (
    AC_COUPLING,
    CHANNEL_GAIN,
    CHANNEL_LAG,
    CLIPPING,
    DROPOUTS,
    MAINS_HUM,
    OFFSET_DRIFT,
    SENSOR_BANDWIDTH,
    SENSOR_NONLINEARITY,
)
from identify.effects.stiffness import (
    BILINEAR_STIFFNESS,
    CUBIC_STIFFNESS,
    LINEAR_STIFFNESS,
    QUADRATIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    SIGNED_QUADRATIC_STIFFNESS,
)
from identify.effects.time import HARMONIC_FORCING, SETTLING_STIFFNESS, TIME_VARYING_STIFFNESS

BASE: tuple[ForceEffect, ...] = (LINEAR_STIFFNESS, COULOMB_FRICTION, VISCOUS_DAMPING)

DAMPING_BY_ORDER: tuple[ForceEffect, ...] = (
    COULOMB_FRICTION,
    VISCOUS_DAMPING,
    QUADRATIC_DAMPING,
    CUBIC_DAMPING,
)
"""The damping |v|^n sgn(v) of each order n that has a name, from n = 0 up."""

STIFFNESS_BY_ORDER: dict[int, ForceEffect] = {
    1: LINEAR_STIFFNESS,
    2: QUADRATIC_STIFFNESS,
    3: CUBIC_STIFFNESS,
    5: QUINTIC_STIFFNESS,
}
"""The spring u^n of each order n that has a name."""

LIBRARY: tuple[Effect, ...] = (
    *BASE,
    QUADRATIC_DAMPING,
    CUBIC_DAMPING,
    POSITION_DEPENDENT_DAMPING,
    STRIBECK_FRICTION,
    POSITION_DEPENDENT_FRICTION,
    CUBIC_STIFFNESS,
    QUADRATIC_STIFFNESS,
    SIGNED_QUADRATIC_STIFFNESS,
    QUINTIC_STIFFNESS,
    PENDULUM_STIFFNESS,
    END_STOP,
    IMPACT,
    FREEPLAY,
    BILINEAR_STIFFNESS,
    DAHL_FRICTION,
    HYSTERESIS,
    MAXWELL_ELEMENT,
    SECOND_MASS,
    TIME_VARYING_STIFFNESS,
    SETTLING_STIFFNESS,
    HARMONIC_FORCING,
    CHANNEL_LAG,
    CHANNEL_GAIN,
    OFFSET_DRIFT,
    CLIPPING,
    SENSOR_NONLINEARITY,
    AC_COUPLING,
    SENSOR_BANDWIDTH,
    MAINS_HUM,
    DROPOUTS,
)


def find_effect(name: str, library: tuple[Effect, ...] | None = None) -> Effect:
    """Return the effect of that name; KeyError, naming those there are, when there is none."""
    library = LIBRARY if library is None else library
    for effect in library:
        if effect.name == name:
            return effect
    raise KeyError(f"no effect is called '{name}'; there are: {', '.join(effect.name for effect in library)}")


def fault_allowed_as(allowance: Allowance) -> SensorFault:
    """Return the fault that every fit allows for in a certain way; KeyError when there is none."""
    for effect in LIBRARY:
        if isinstance(effect, SensorFault) and effect.allowed_as == allowance:
            return effect
    raise KeyError(f"no fault is allowed for as {allowance}")
