"""Effects that depend on time itself."""

from collections.abc import Mapping
from math import exp, pi, sin
from typing import Any

from identify.effects.effect import Parameter, Scales, Starts, near_harmonic, shares_of
from identify.effects.force_effect import ForceEffect

TIME_VARYING_STIFFNESS = ForceEffect(
    of_time=True,
    name="time_varying_stiffness",
    title="stiffness that drifts with time",
    equation="k rate t u",
    parameters=(Parameter("rate", "1/s", "relative change of the stiffness per second since the release"),),
    shared_parameters={"linear_stiffness.k": lambda frequency: frequency**2},
    force=lambda t, u, v, z, p: p[0] * p[1] * t * u,
    symptom="the frequency changes with time, not with amplitude",
    confirming_test="a second release at a quarter of the amplitude: the drift with time is the same",
    confusable_with=("settling_stiffness", "cubic_stiffness", "freeplay"),
)


_IN_A_TIME: Mapping[str, Any] = {
    "of_time": True,
    "starts": shares_of("duration", 0.1, 0.3, 0.8),
    "reach": shares_of("duration", 0.005, 0.015, 0.04, 0.09, 0.17, 0.3, 0.6, 1.5),
    "plausible": lambda values, scales: 2.0 * pi / scales.frequency < values["tau"] < 1.5 * scales.duration,
}
"""Where a law that settles in the time `tau` is looked for; beyond that it is one that drifts, or none."""


SETTLING_STIFFNESS = ForceEffect(
    **_IN_A_TIME,
    name="settling_stiffness",
    title="stiffness that settles (warming)",
    equation="k r (1 - exp(-t/tau)) u",
    parameters=(
        Parameter("r", "1", "relative change of the stiffness from the release to the end"),
        Parameter("tau", "s", "time in which it settles", 0.0),
    ),
    shared_parameters={"linear_stiffness.k": lambda frequency: frequency**2},
    force=lambda t, u, v, z, p: p[0] * p[2] * (1.0 - exp(-t / p[1])) * u,
    symptom="the frequency changes with time and then settles, at any amplitude",
    confirming_test="a second release soon after the first: the frequency begins where the first one ended",
    confusable_with=("time_varying_stiffness", "cubic_stiffness", "freeplay"),
)


FADING_FRICTION = ForceEffect(
    **_IN_A_TIME,
    name="fading_friction",
    title="friction that fades or grows with time (warming, running in)",
    equation="dmu exp(-t/tau) sgn v",
    parameters=(
        Parameter("dmu", "m/s^2", "friction that is lost in the end, per unit mass; negative where it grows"),
        Parameter("tau", "s", "time in which it fades", 0.0),
    ),
    friction=lambda t, u, v, z, p: p[0] * exp(-t / p[1]),
    symptom="the straight-line decay becomes less steep, or steeper, with time, at any amplitude",
    confirming_test="a second release soon after the first: the friction begins where the first one ended",
    confusable_with=("fading_damping", "position_dependent_friction"),
)


FADING_DAMPING = ForceEffect(
    **_IN_A_TIME,
    name="fading_damping",
    title="damping that fades or grows with time (warming)",
    equation="c exp(-t/tau) v",
    parameters=(
        Parameter("c", "1/s", "damping that is lost in the end, per unit mass; negative where it grows"),
        Parameter("tau", "s", "time in which it fades", 0.0),
    ),
    force=lambda t, u, v, z, p: p[0] * exp(-t / p[1]) * v,
    symptom="the decrement falls or rises with time, at any amplitude",
    confirming_test="a second release soon after the first: the damping begins where the first one ended",
    confusable_with=("fading_friction", "quadratic_damping"),
)


def _line_starts(scales: Scales) -> Starts:
    """Return the lines of all channels with the phases that a force may have beside that of a displacement's line."""
    lines = [line for found in scales.lines.values() for line in found]
    return tuple(
        (f, (phase + quarter * 0.5 * pi) % (2.0 * pi)) for f, _, phase in lines for quarter in range(4)
    )


_RESOLVED = 0.25
"""Share of its frequency that a force of time alone needs: quadrature over steps of 0.2 rad errs by 1e-6 of it (Simpson)."""


HARMONIC_FORCING = ForceEffect(
    name="harmonic_forcing",
    title="shaking from outside at one frequency",
    equation="-amp sin(2 pi f t + phase)",
    parameters=(
        Parameter("amp", "m/s^2", "amplitude of the force per unit mass", 0.0),
        Parameter("f", "Hz", "frequency", 0.0),
        Parameter("phase", "rad", "phase at the release", of_release=True),
    ),
    force=lambda t, u, v, z, p: -p[0] * sin(2.0 * pi * p[1] * t + p[2]),
    starts=_line_starts,
    plausible=lambda values, scales: not near_harmonic(values["f"], scales),
    line=True,
    fastest_rate=lambda p: _RESOLVED * 2.0 * pi * float(p[1]),
    symptom="a line that does not decay, in every channel, acceleration with -w^2 times the displacement",
    confirming_test="record without a release: the line is still there",
    confusable_with=("second_mass", "mains_hum"),
)
