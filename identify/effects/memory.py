"""Effects with memory: forces that depend on where the mass has been."""

from math import hypot, pi

import numpy as np

from identify.effects.effect import Parameter, Scales, Starts, near_harmonic
from identify.effects.force_effect import ForceEffect

MAXWELL_ELEMENT = ForceEffect(
    name="maxwell_element",
    title="spring and dashpot in series (Maxwell)",
    equation="k1 (u - q),  q' = (u - q)/tau",
    parameters=(
        Parameter("k1", "1/s^2", "stiffness per unit mass", 0.0),
        Parameter("tau", "s", "relaxation time", 0.0),
    ),
    force=lambda t, u, v, z, p: p[0] * (u - z[0]),
    rates=lambda t, u, v, z, p: ((u - z[0]) / p[1], 0.0),
    states=1,
    proportional=True,
    equilibrium_state=lambda u, p: (u, 0.0),
    starts=lambda scales: tuple((share / scales.frequency,) for share in (0.2, 0.5, 1.2, 3.0, 10.0)),
    reach=lambda scales: tuple(
        (share / scales.frequency,)
        for share in (0.07, 0.15, 0.3, 0.6, 1.2, 2.5, 5.0, 10.0, 20.0, 50.0, 200.0)
    ),
    # a step is about one relaxation time: stable, and fine enough for a state that only follows
    fastest_rate=lambda p: 0.05 / max(float(p[1]), 1e-4),
    symptom="at one frequency it looks like stiffness and viscous damping; it shows only in the transient",
    confirming_test="add a known mass: the damping changes with frequency as k1 tau/(1 + w^2 tau^2)",
    confusable_with=("viscous_damping", "linear_stiffness", "ac_coupling"),
)


_LOWEST, _HIGHEST = 0.3, 8.0
"""Frequency of a second mass over the motion's: a slower one is a drift, a faster one a mode that other_modes tells."""

_TUNED = 0.1
"""Relative distance from the motion's frequency within which a second mass is tuned to it."""

_LASTING = 3.0
"""Amplitudes' decay, as an exponent over the record, up to which a line lasts like a harmonic of the motion."""

_CLOSE, _WIDE, _APART = 150, 30, 4.0
"""Most lines that last, lines that die soon, and the distance of the former times the record: a third of a line's width."""


def _line_starts(scales: Scales) -> Starts:
    highest = min(3.0 * scales.rate, _HIGHEST * scales.frequency)
    frequencies = [2.0 * pi * line for line in scales.line_frequencies]
    frequencies += [0.4 * scales.frequency * 1.1**i for i in range(32)]
    return tuple((frequency, 0.02) for frequency in frequencies if frequency < highest)


def _reachable_lines(scales: Scales) -> Starts:
    """Return frequencies as close as the record resolves them, up to a number, where little is lost; farther apart else."""
    low, high = _LOWEST * scales.frequency, min(3.0 * scales.rate, _HIGHEST * scales.frequency)
    close = np.linspace(low, high, min(_CLOSE, int((high - low) * scales.duration / _APART) + 2))
    wide = np.geomspace(low, high, _WIDE)
    return tuple((float(w), 0.003) for w in close) + tuple((float(w), 0.04) for w in wide)


def _is_tuned(w2: float, frequency: float) -> bool:
    return abs(w2 / frequency - 1.0) <= _TUNED


def _has_a_line_of_its_own(values: dict[str, float], scales: Scales) -> bool:
    """Check whether the line of a second mass is one: not the motion's own, nor one of its harmonics that lasts as they do.

    Tuned to the motion, as a damper is, its line stands apart by its own distance and by the root of the ratio of masses
    (Den Hartog 1934): that shows where it is more than either line is wide, by half a beat at least within the record.
    """
    w2 = values["w2"]
    split = hypot(w2 - scales.frequency, scales.frequency * values["ratio"] ** 0.5)
    damping = values["zeta"] * w2
    if _is_tuned(w2, scales.frequency):
        return bool(split > damping and split * scales.duration > pi)
    harmonic = w2 > 1.5 * scales.frequency and near_harmonic(w2 / (2.0 * pi), scales)
    return not (harmonic and damping * scales.duration < _LASTING)


SECOND_MASS = ForceEffect(
    name="second_mass",
    title="a second mass on a spring of its own",
    equation="ratio (w2^2 (u - y) + 2 zeta w2 (v - y')),  y'' = w2^2 (u - y) + 2 zeta w2 (v - y')",
    parameters=(
        Parameter("ratio", "1", "second mass over the first", 0.0, 1.0),
        Parameter("w2", "rad/s", "angular frequency of the second mass on its spring", 0.0),
        Parameter("zeta", "1", "damping ratio of the second mass", 0.0, 1.0),
    ),
    force=lambda t, u, v, z, p: p[0] * (p[1] * p[1] * (u - z[0]) + 2.0 * p[2] * p[1] * (v - z[1])),
    rates=lambda t, u, v, z, p: (z[1], p[1] * p[1] * (u - z[0]) + 2.0 * p[2] * p[1] * (v - z[1])),
    states=2,
    proportional=True,
    beats_with=lambda p, frequency: _is_tuned(float(p[1]), frequency),
    equilibrium_state=lambda u, p: (u, 0.0),
    starts=_line_starts,
    plausible=_has_a_line_of_its_own,
    reach=_reachable_lines,
    fastest_rate=lambda p: 0.6 * float(p[1]),
    symptom="a second line that starts at the release and decays on its own; beats; another mode of the rig looks the same, "
    "and so may a slow change of the sensor or of the plane of swing where less than a beat was recorded",
    confirming_test="clamp or remove the suspected part: the second line is gone",
    confusable_with=("harmonic_forcing", "linear_stiffness"),
)
