"""Faults of a sensor: they change a reading, not the motion, and so break a = D^2 u."""

from math import atan, pi

import numpy as np

from identify.algebra import recursion
from identify.arrays import Array
from identify.effects.effect import Parameter, Scales, Starts, near_harmonic
from identify.effects.sensor_fault import SensorFault

CHANNEL_LAG = SensorFault(
    name="channel_lag",
    title="one channel is late",
    equation="u(t - lag)",
    parameters=(Parameter("lag", "s", "delay of the displacement (or velocity) behind the acceleration"),),
    corrected_in_every_fit=True,
    variants=({},),
    symptom="the error of a = D^2 u is proportional to the jerk",
    confirming_test="normal: every record is corrected for it",
)

CHANNEL_GAIN = SensorFault(
    name="channel_gain",
    title="the gains of the two channels disagree",
    equation="(1 + error) a",
    parameters=(Parameter("error", "1", "gain of the acceleration relative to the displacement, less one"),),
    corrected_in_every_fit=True,
    variants=({},),
    symptom="the error of a = D^2 u is proportional to the acceleration",
    confirming_test="calibrate both sensors against one reference; another spring: a tilt or a roll-off changes with it",
    confusable_with=("sensor_bandwidth",),
)


OFFSET_DRIFT = SensorFault(
    name="offset_drift",
    title="the zero of a sensor drifts",
    equation="reading + rate t",
    parameters=(Parameter("rate", "reading/s", "drift of the zero"),),
    observe=lambda time, reading, p: reading + p[0] * time,
    starts=lambda scales, channel: ((1e-4 * scales.peaks[channel] / scales.duration,),),
    shows_at_rest=True,
    symptom="the mean of one channel moves steadily, and the other does not follow",
    confirming_test="record ten seconds without motion: the zero still moves",
    confusable_with=("quadratic_stiffness", "bilinear_stiffness"),
)


CLIPPING = SensorFault(
    name="clipping",
    title="a sensor or converter saturates",
    equation="clip(reading, center - limit, center + limit)",
    parameters=(
        Parameter("limit", "reading", "largest reading on either side of the centre", 0.0),
        Parameter("center", "reading", "middle of the range, from the sensor's zero"),
    ),
    observe=lambda time, reading, p: np.clip(reading, p[1] - p[0], p[1] + p[0]),
    starts=lambda scales, channel: tuple(
        (share * scales.peaks[channel], 0.0) for share in (0.995, 0.97, 0.9)
    ),
    inner=("limit",),
    symptom="flat peaks in one channel only, at one level",
    confirming_test="release from a smaller amplitude, or choose a larger range",
    confusable_with=("end_stop", "cubic_stiffness"),
)


def _high_pass(time: Array, reading: Array, p: Array) -> Array:
    if len(time) < 2:
        return reading
    step = float(time[1] - time[0])
    rate = 2.0 * pi * p[0]
    keep = float(np.exp(-rate * step))
    ramp = (1.0 - keep) / (rate * step) if rate * step > 1e-9 else 1.0
    jumps = np.empty(len(reading))
    jumps[0] = reading[0]
    jumps[1:] = ramp * (reading[1:] - reading[:-1])
    passed = recursion(jumps, keep)
    return np.asarray(passed + p[1] * np.exp(-rate * (time - time[0])))


_MEMORY = 5.0
"""Times what a cycle of the largest motion leaves in a coupling: it cannot remember more, from rest or from motion."""

AC_COUPLING = SensorFault(
    name="ac_coupling",
    title="a sensor does not hold a constant reading (AC coupling)",
    equation="first-order high-pass at fc",
    parameters=(
        Parameter("fc", "Hz", "corner frequency", 0.0),
        Parameter("transient", "reading", "state of the high-pass where the fit begins"),
    ),
    observe=_high_pass,
    starts=lambda scales, channel: tuple(
        # closely spaced: where dry friction reverses, chi-square has steps between them
        (0.003 * 1.33**i * scales.frequency / (2.0 * pi), 0.0)
        for i in range(14)
    ),
    inner=("fc",),
    plausible=lambda values, scales: (
        abs(values["transient"])
        < _MEMORY * 2.0 * pi * values["fc"] / scales.frequency * max(scales.peaks.values())
    ),
    seems_lag=lambda start, scales: 2.0 * pi * start[0] / scales.frequency**2,
    symptom="one channel leads in phase, more at low frequency, and its mean returns to zero",
    confirming_test="hold the mass off its zero: the reading creeps back",
    confusable_with=("channel_lag", "maxwell_element", "viscous_damping"),
)


_BEND = 1e-3
"""Share of the full range by which a sensor may be taken to bend at first."""

_MOST_BEND = 0.1
"""Share of the full range beyond which a sensor does not bend, it is broken."""


def _bend_starts(scales: Scales, channel: str) -> Starts:
    peak = scales.peaks[channel]
    return (_BEND / peak, 0.0), (-_BEND / peak, 0.0), (0.0, _BEND / peak**2)


def _bends_little(values: dict[str, float], scales: Scales) -> bool:
    peak = max(scales.peaks.values())
    return abs(values["quadratic"]) * peak < _MOST_BEND and abs(values["cubic"]) * peak**2 < _MOST_BEND


SENSOR_NONLINEARITY = SensorFault(
    name="sensor_nonlinearity",
    title="a sensor is nonlinear",
    equation="x + quadratic x^2 + cubic x^3",
    parameters=(
        Parameter("quadratic", "1/(reading)", "relative error per reading"),
        Parameter("cubic", "1/(reading)^2", "relative error per squared reading"),
    ),
    observe=lambda time, reading, p: reading * (1.0 + reading * (p[0] + reading * p[1])),
    starts=_bend_starts,
    plausible=_bends_little,
    needs_other_channel=True,
    symptom="harmonics and a shifted mean in one channel, which the other does not show",
    confirming_test="calibrate the sensor over its range, or use another part of it",
    confusable_with=("quadratic_stiffness", "cubic_stiffness", "clipping"),
)


SENSOR_BANDWIDTH = SensorFault(
    name="sensor_bandwidth",
    title="a sensor is slow (first-order roll-off)",
    equation="first-order low-pass at fc",
    parameters=(
        Parameter("fc", "Hz", "corner frequency", 0.0),
        Parameter("transient", "reading", "state of the low-pass where the fit begins"),
    ),
    observe=lambda time, reading, p: reading - _high_pass(time, reading - reading[:1], p),
    starts=lambda scales, channel: tuple(
        (ratio * scales.frequency / (2.0 * pi), 0.0) for ratio in (3.0, 8.0, 20.0, 100.0)
    ),
    inner=("fc",),
    plausible=lambda values, scales: scales.frequency / (2.0 * pi) < values["fc"] < 0.5 * scales.rate,
    seems_lag=lambda start, scales: -atan(scales.frequency / (2.0 * pi * start[0])) / scales.frequency,
    needs_other_channel=True,
    symptom="one channel smooths what is sudden in the other; it follows slow motion late and a little too small",
    confirming_test="tap the mass: the sensor's answer is longer than the other's",
    confusable_with=("channel_lag", "channel_gain", "dahl_friction"),
)


_HUM_FROM = 2.5
"""Multiple of the motion's frequency above which a line may be called hum; a slower one is a motion."""


MAINS_HUM = SensorFault(
    name="mains_hum",
    title="hum in one channel",
    equation="reading + amp sin(2 pi f t + phase)",
    parameters=(
        Parameter("amp", "reading", "amplitude of the hum", 0.0),
        Parameter("f", "Hz", "frequency (as sampled)", 0.0),
        Parameter("phase", "rad", "phase at the release"),
    ),
    observe=lambda time, reading, p: reading + p[0] * np.sin(2.0 * pi * p[1] * time + p[2]),
    starts=lambda scales, channel: tuple(
        (amplitude, line, phase) for line, amplitude, phase in scales.lines.get(channel, ()) if line > 0.0
    ),
    inner=("f",),
    shows_at_rest=True,
    plausible=lambda values, scales: (
        values["f"] > _HUM_FROM * scales.frequency / (2.0 * pi) and not near_harmonic(values["f"], scales)
    ),
    line=True,
    symptom="a line in one channel only, there before the release",
    confirming_test="record at rest: the line is there; move the cables or the supply: it changes",
    confusable_with=("harmonic_forcing",),
)

DROPOUTS = SensorFault(
    name="dropouts",
    title="a sensor repeats or loses readings",
    equation="single readings stand still or fall to zero",
    parameters=(Parameter("share", "1", "share of the readings that are wrong", 0.0, 1.0),),
    corrected_in_every_fit=True,
    symptom="isolated readings of one channel far off its neighbours, while the other channel runs on",
    confirming_test="record again with another cable; compare where the readings fail",
)
