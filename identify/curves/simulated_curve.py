"""The curve that a model predicts: its free run, seen through the windows of the measured one."""

import numpy as np

from identify.curves.decay_curve import DecayCurve
from identify.curves.isolated_mode import IsolatedMode
from identify.fitting.initial_values import initial_nuisances, initial_values
from identify.fitting.problem import Problem
from identify.model.model import Model
from identify.preprocessing.prepared_decay import PreparedDecay

_MENDED = 8
_CLOSE = 1e-4
"""Times that the start is mended, at most, and the share of the amplitude to which it then agrees."""


def simulated_curve(
    prepared: PreparedDecay, mode: IsolatedMode, model: Model, values: dict[str, float], measured: DecayCurve
) -> DecayCurve | None:
    """Return the curve of a model run from the start of the measured one; None where the motion runs away or dies.

    `values` are the parameters of its effects by unknown's name, as if the release were the only one. The run begins
    with the measured motion under the first window, and again with its amplitude and phase mended at the first point of
    the curve until they agree.
    """
    at = int(mode.first[0])
    window = prepared.window.part(slice(at, None)).with_(pre_release=None)
    problem = Problem(model, (window,), prepared.frequency)
    begin = initial_nuisances if all(str(t.strength) in values for t in model.forces) else initial_values
    theta = problem.theta(begin((prepared,), model, values) | values)
    places = list(problem.layout.releases[0].start)
    theta[places] = prepared.motion.displacement[at], prepared.motion.velocity[at]
    curve = None
    for _ in range(_MENDED):
        theta = np.clip(theta, problem.low, problem.high)
        predicted = problem.read(theta, 0, problem.respond(theta, 0))[mode.channel]
        if not np.isfinite(predicted).all():
            return None
        curve = mode.curve(np.concatenate([np.zeros(at), predicted]))
        if not (curve.amplitude > 0.0).all():
            return None
        u, v = theta[places]
        state = complex(u, -v / mode.frequency[0])
        turn = np.exp(1j * (measured.phase[0] - curve.phase[0])) * measured.amplitude[0] / curve.amplitude[0]
        if abs(turn - 1.0) < _CLOSE:
            break
        theta[places] = (state * turn).real, -(state * turn).imag * mode.frequency[0]
    return curve
