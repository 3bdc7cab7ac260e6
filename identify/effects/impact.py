"""Impact on an end stop that takes energy."""

from math import inf

from identify.effects.compiled import force_function
from identify.effects.effect import Parameter, Scales, Starts
from identify.effects.force_effect import ForceEffect


@force_function
def _impact(t, u, v, z, p):  # type: ignore[no-untyped-def]
    force = 0.0
    if p[2] >= 0.0 and u > p[1]:
        force = p[0] * (u - p[1]) * max(1.0 + p[3] * v, 0.0)
    if p[2] <= 0.0 and u < -p[1]:
        force = p[0] * (u + p[1]) * max(1.0 - p[3] * v, 0.0)
    return force


_CLOSEST = 0.35
"""Share of the amplitude below which a gap is play."""

_LEAST = 0.2
"""Loss times the largest speed below which the stop counts as elastic: it gives back 87 % of the speed."""


def _starts(scales: Scales) -> Starts:
    return tuple((share * scales.amplitude, 0.4 / scales.speed) for share in (0.35, 0.6, 0.8))


_GAPS = (0.02, 0.08, 0.26, 0.46, 0.63, 0.76, 0.87, 0.95)
_LOSSES = (0.0, 1.0, 3.0, 10.0)
"""Gaps over the amplitude, and losses times the largest speed, that a fit may reach; 10 is nearly all on the way in."""


def _reach(scales: Scales) -> Starts:
    return tuple((share * scales.amplitude, loss / scales.speed) for share in _GAPS for loss in _LOSSES)


IMPACT = ForceEffect(
    name="impact_with_loss",
    title="end stop that takes energy (Hunt and Crossley)",
    equation="ks max(u - gap, 0) (1 + loss v) on side +1, -1 or both (0)",
    parameters=(
        Parameter("ks", "1/s^2", "stiffness of the stop per unit mass", 0.0, inf),
        Parameter("gap", "m", "displacement at which it is met", 0.0, inf),
        Parameter("side", "1", "+1, -1, or 0 for both"),
        Parameter(
            "loss",
            "s/m",
            "damping of the stop: a contact takes 2/3 loss v of the speed v at which it begins",
            0.0,
            inf,
        ),
    ),
    force=_impact,
    starts=_starts,
    reach=_reach,
    variants=({"side": 1.0}, {"side": -1.0}, {"side": 0.0}),
    plausible=lambda values, scales: (
        values["gap"] > _CLOSEST * scales.amplitude and values["loss"] * scales.speed > _LEAST
    ),
    symptom="nothing happens below the gap; above it the force has a kink, and every contact takes energy",
    confirming_test="release from just below the gap: the effect is gone, the extra loss with it",
    confusable_with=("end_stop", "quintic_stiffness", "cubic_damping", "clipping"),
    nonsmooth=True,
)
