"""Joints and asperities that give way: springs whose state is a share of what they give way at."""

from functools import partial
from math import copysign

from identify.arrays import Array
from identify.effects.compiled import effect_function
from identify.effects.effect import Parameter, shares_of
from identify.effects.force_effect import ForceEffect

_SHORTEST = 0.01
"""Presliding displacement over the amplitude below which the friction is a dry one."""


def _held_state(u: float, p: Array) -> tuple[float, float]:
    """Return the states of a joint that has been held at u (m) for long: u over what it gives way at, p[1] (m), 1 at most.

    One that gives way at nothing has no force; its state is 0.
    """
    gives_way = float(p[1])
    return copysign(min(abs(u) / gives_way, 1.0), u) if gives_way > 0.0 else 0.0, 0.0


joint = partial(
    ForceEffect,
    force=effect_function(lambda t, u, v, z, p: p[0] * p[1] * z[0]),
    states=1,
    largest_state=1.0,
    fading_memory=False,
    equilibrium_state=_held_state,
    nonsmooth=True,
)
"""A force of stiffness p[0] that gives way at p[1]; its `rates` say how."""

STIFFNESS = Parameter("kh", "1/s^2", "stiffness of the joint before it slips, per unit mass", 0.0)
YIELD = Parameter("uy", "m", "displacement at which it yields", 0.0)


def _hysteresis_rates(t, u, v, z, p):  # type: ignore[no-untyped-def]
    if p[1] <= 0.0:
        return 0.0, 0.0
    if v * z[0] > 0.0:
        return v * (1.0 - z[0] * z[0]) / p[1], 0.0
    return v / p[1], 0.0


HYSTERESIS = joint(
    name="hysteresis",
    title="hysteresis (micro-slip in a joint)",
    equation="kh uy z,  z' = (v/uy) (1 - z^2 [v z > 0])",
    parameters=(STIFFNESS, YIELD),
    rates=_hysteresis_rates,
    starts=shares_of("amplitude", 0.1, 0.25, 0.6),
    reach=shares_of("amplitude", 0.03, 0.06, 0.1, 0.16, 0.25, 0.4, 0.65, 1.0, 2.0, 5.0, 15.0, 50.0),
    gives_way=lambda p: 0.5 * float(p[1]),
    symptom="a loop in the plane of displacement and force; softer at large amplitude",
    confirming_test="the loss per cycle stops growing once the amplitude is well above the yield displacement",
    confusable_with=("coulomb_friction", "freeplay", "position_dependent_friction"),
)

DAHL_FRICTION = joint(
    name="dahl_friction",
    title="friction that gives way before it slides (Dahl)",
    equation="kd ud z,  z' = (v/ud) (1 - z sgn v)",
    parameters=(
        Parameter("kd", "1/s^2", "stiffness at a reversal, per unit mass", 0.0),
        Parameter("ud", "m", "displacement over which it gives way; kd ud is the friction", 0.0),
    ),
    rates=lambda t, u, v, z, p: ((v - abs(v) * z[0]) / p[1] if p[1] > 0.0 else 0.0, 0.0),
    starts=shares_of("amplitude", 0.03, 0.1, 0.3),
    reach=shares_of("amplitude", 0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6, 1.2, 1.8, 2.5, 4.0, 6.0, 15.0, 60.0),
    gives_way=lambda p: float(p[1]),
    plausible=lambda values, scales: _SHORTEST * scales.amplitude < values["ud"] < scales.amplitude,
    symptom="dry friction that rises gradually after each reversal, without a jump; stiffer at small amplitude",
    confirming_test="move the mass by less than ud, slowly: it springs back",
    confusable_with=("hysteresis", "coulomb_friction", "position_dependent_friction"),
)
