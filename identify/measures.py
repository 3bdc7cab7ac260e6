"""The three errors of a model: of the force, of the free-run motion, and against the noise floor."""

from dataclasses import dataclass

import numpy as np

from identify.equation_error import moving
from identify.search import Start, force_along_motion


@dataclass(frozen=True)
class Error:
    """How far a model is from the measurement.

    `force_mse_percent` is eq. (18) on the measured acceleration, `motion_percent` the free-run misfit of the
    displacement (or the first channel there is) in percent of its rms over `horizon_s`, `chi_square` the reduced
    chi-square, 1.0 when nothing is left to explain, and `floor_std` its standard error for an adequate model.
    """

    force_mse_percent: float
    motion_percent: float
    horizon_s: float
    chi_square: float
    floor_std: float


def errors_of(start: Start) -> Error:
    """Return the errors of a fitted model, over all its releases."""
    force, motion, horizon = [], [], 0.0
    for i, (setting, span) in enumerate(zip(start.settings, start.fit.spans, strict=True)):
        used = moving(setting.motion)
        measured = setting.restoring[used]
        model = force_along_motion(setting, start.fit)[used]
        force.append(100.0 * float(np.mean((measured - model) ** 2) / np.var(measured)))
        channel = span.channels[0]
        kept = span.used[channel]
        reading = span.readings[channel][kept]
        misfit = start.fit.residual(channel, i)[kept]
        motion.append(100.0 * float(np.sqrt(np.mean(misfit**2)) / np.std(reading)))
        horizon = max(horizon, len(span) / span.rate)
    return Error(
        float(np.mean(force)),
        float(np.sqrt(np.mean(np.square(motion)))),
        horizon,
        start.reduced(start.fit),
        start.spread,
    )
