"""Contact: stops that are met at a gap, with and without loss, and play in a joint."""

from identify.effects.compiled import effect_function
from identify.effects.effect import Parameter, Scales, Starts, shares_of
from identify.effects.force_effect import ForceEffect

_PLAY_SHARE = 0.35
"""A gap below this share of the amplitude is called play, one above it an end stop: the forces are the same."""

_LEAST_LOSS = 0.2
"""Loss times the largest speed below which the stop counts as elastic: it gives back 87 % of the speed."""

_GAPS = (0.02, 0.08, 0.26, 0.46, 0.63, 0.76, 0.87, 0.95)
_LOSSES = (0.0, 1.0, 3.0, 10.0)
"""Gaps over the amplitude, and losses times the largest speed, that a fit may reach; 10 is nearly all on the way in."""

_STIFFNESS = Parameter("ks", "1/s^2", "stiffness of the stop per unit mass", 0.0)
_GAP = Parameter("gap", "m", "displacement at which it is met", 0.0)
_SIDE = Parameter("side", "1", "+1, -1, or 0 for both")
_LOSS = Parameter(
    "loss", "s/m", "damping of the stop: a contact takes 2/3 loss v of the speed v at which it begins", 0.0
)
_SIDES: tuple[dict[str, float | str], ...] = ({"side": 1.0}, {"side": -1.0}, {"side": 0.0})


@effect_function
def _stop(t, u, v, z, p):  # type: ignore[no-untyped-def]
    """Stiffness, gap, side and loss in this order; an elastic stop has no loss."""
    force = 0.0
    if p[2] >= 0.0 and u > p[1]:
        force = p[0] * (u - p[1]) * max(1.0 + p[3] * v, 0.0)
    if p[2] <= 0.0 and u < -p[1]:
        force = p[0] * (u + p[1]) * max(1.0 - p[3] * v, 0.0)
    return force


def _reach_with_loss(scales: Scales) -> Starts:
    return tuple((gap * scales.amplitude, loss / scales.speed) for gap in _GAPS for loss in _LOSSES)


END_STOP = ForceEffect(
    name="end_stop",
    title="end stop",
    equation="ks max(u - gap, 0) on side +1, -1 or both (0)",
    parameters=(_STIFFNESS, _GAP, _SIDE),
    force=_stop,
    starts=shares_of("amplitude", 0.35, 0.6, 0.8),
    # gaps of play too
    reach=shares_of(
        "amplitude", 0.03, 0.08, 0.16, 0.26, 0.36, 0.46, 0.55, 0.63, 0.7, 0.76, 0.82, 0.87, 0.91, 0.95
    ),
    variants=_SIDES,
    plausible=lambda values, scales: values["gap"] > _PLAY_SHARE * scales.amplitude,
    symptom="nothing happens below the gap; above it the force has a kink",
    confirming_test="release from just below the gap: the effect is gone",
    confusable_with=("freeplay", "cubic_stiffness", "quintic_stiffness", "bilinear_stiffness", "clipping"),
    nonsmooth=True,
)

IMPACT = ForceEffect(
    name="impact_with_loss",
    title="end stop that takes energy (Hunt and Crossley)",
    equation="ks max(u - gap, 0) (1 + loss v) on side +1, -1 or both (0)",
    parameters=(_STIFFNESS, _GAP, _SIDE, _LOSS),
    force=_stop,
    starts=lambda scales: tuple((gap * scales.amplitude, 0.4 / scales.speed) for gap in (0.35, 0.6, 0.8)),
    reach=_reach_with_loss,
    variants=_SIDES,
    plausible=lambda values, scales: (
        values["gap"] > _PLAY_SHARE * scales.amplitude and values["loss"] * scales.speed > _LEAST_LOSS
    ),
    symptom="nothing happens below the gap; above it the force has a kink, and every contact takes energy",
    confirming_test="release from just below the gap: the effect is gone, the extra loss with it",
    confusable_with=("end_stop", "quintic_stiffness", "cubic_damping", "clipping"),
    nonsmooth=True,
)

FREEPLAY = ForceEffect(
    name="freeplay",
    title="play in a joint",
    equation="-kf clip(u, -gap, gap)",
    parameters=(
        Parameter("kf", "1/s^2", "stiffness missing inside the play, per unit mass", 0.0),
        Parameter("gap", "m", "half of the play", 0.0),
    ),
    force=lambda t, u, v, z, p: -p[0] * min(max(u, -p[1]), p[1]),
    starts=shares_of("amplitude", 0.06, 0.14, 0.3),
    reach=shares_of("amplitude", 0.01, 0.02, 0.04, 0.07, 0.12, 0.2, 0.35, 0.6, 0.85),
    plausible=lambda values, scales: values["gap"] <= _PLAY_SHARE * scales.amplitude,
    symptom="softer at small amplitude",
    confirming_test="release from a few times the gap: the frequency falls further",
    confusable_with=("end_stop", "cubic_stiffness", "time_varying_stiffness", "hysteresis"),
    nonsmooth=True,
)
