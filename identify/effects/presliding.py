"""Friction before sliding: an asperity bends as a spring does, and slides in the end."""

from math import inf

from identify.effects.compiled import rate_function
from identify.effects.effect import Parameter, Scales
from identify.effects.force_effect import ForceEffect
from identify.effects.joint import held_state, joint_force

_SHORTEST = 0.01
"""Presliding displacement over the amplitude below which the friction is a dry one."""


_DISPLACEMENTS = (0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6, 1.2, 1.8, 2.5, 4.0, 6.0, 15.0, 60.0)


@rate_function
def _dahl_rates(t, u, v, z, p):  # type: ignore[no-untyped-def]
    return (v - abs(v) * z[0]) / p[1] if p[1] > 0.0 else 0.0, 0.0


def _slides(values: dict[str, float], scales: Scales) -> bool:
    return _SHORTEST * scales.amplitude < values["ud"] < scales.amplitude


DAHL_FRICTION = ForceEffect(
    name="dahl_friction",
    title="friction that gives way before it slides (Dahl)",
    equation="kd ud z,  z' = (v/ud) (1 - z sgn v)",
    parameters=(
        Parameter("kd", "1/s^2", "stiffness at a reversal, per unit mass", 0.0, inf),
        Parameter("ud", "m", "displacement over which it gives way; kd ud is the friction", 0.0, inf),
    ),
    force=joint_force,
    rates=_dahl_rates,
    states=1,
    largest_state=1.0,
    fading_memory=False,
    equilibrium_state=held_state,
    starts=lambda scales: tuple((share * scales.amplitude,) for share in (0.03, 0.1, 0.3)),
    reach=lambda scales: tuple((share * scales.amplitude,) for share in _DISPLACEMENTS),
    gives_way=lambda p: float(p[1]),
    plausible=_slides,
    symptom="dry friction that rises gradually after each reversal, without a jump; stiffer at small amplitude",
    confirming_test="move the mass by less than ud, slowly: it springs back",
    confusable_with=("hysteresis", "coulomb_friction", "position_dependent_friction"),
    nonsmooth=True,
)
