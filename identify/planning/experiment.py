"""An experiment: a release that could be recorded next, and how a fitted model is carried over to it."""

from dataclasses import dataclass, replace

import numpy as np

from identify.fitting.fit import Fit
from identify.free_decay import CHANNELS
from identify.preprocessing.fit_window import FitWindow, PreReleaseMotion
from identify.preprocessing.prepared_decay import PreparedDecay


@dataclass(frozen=True)
class Experiment:
    """A release from `amplitude` (signed, in the unit of the displacement), or a `push` that would reach it.

    `longer` and `faster` are multiples of the record's length and rate; `heavier` is the added mass as a share of the
    mass; `sensor` a further channel; `rested` says that the mass is held still before, so that memory begins at rest.
    """

    amplitude: float
    push: bool = False
    longer: float = 1.0
    faster: float = 1.0
    heavier: float = 0.0
    sensor: str = ""
    rested: bool = False


def window_of(experiment: Experiment, last: PreparedDecay, window: FitWindow) -> FitWindow:
    """Make the window of an experiment; its readings are a cosine until the experiment is simulated.

    `last` is the largest release so far, `window` as it was fitted. The noise is that of the record; of a further sensor it
    is as large a share of the motion as that of the first channel. Coarse where the rate allows: 24 readings a cycle.
    """
    w = last.frequency
    heavier = 1.0 / (1.0 + experiment.heavier)
    share = last.use.share if last.use is not None else 1.0
    samples = int(len(window) / max(share, 0.05) * experiment.longer)
    scale = experiment.amplitude / signed_amplitude(last)
    clock = window.time + np.arange(samples) / window.rate
    sigma = {c: s / np.sqrt(experiment.faster) for c, s in window.sigma.items()}
    channels = list(window.channels)
    if experiment.sensor:
        first = channels[0]
        power = CHANNELS.index(experiment.sensor) - CHANNELS.index(first)
        sigma[experiment.sensor] = window.sigma[first] * w**power
        channels.append(experiment.sensor)
    motion = experiment.amplitude * np.cos(w * np.sqrt(heavier) * clock)
    readings = {c: motion * w ** CHANNELS.index(c) for c in channels}
    used = np.arange(samples) >= window.lead
    before = None if experiment.push else window.pre_release
    if experiment.rested:
        before = _held_before(experiment.amplitude, w, window.time)
    elif before is not None:
        before = PreReleaseMotion(before.time, scale * before.displacement, scale * before.velocity)
    made = replace(
        window,
        readings=readings,
        used=dict.fromkeys(channels, used),
        sigma=sigma,
        colour={c: colour.beside_white(1.0 / experiment.faster) for c, colour in window.colour.items()},
        pre_release=before,
        force=None,
        segment=False,
        release=0,
        own_linear=None,
    )
    return made.at_few_readings(w)


def carried_over(
    experiment: Experiment, last: PreparedDecay, found: Fit
) -> tuple[dict[str, float], dict[str, float]]:
    """Return the values of a fit as an experiment has them, by name, and the factor by which each shared one changed.

    A mass that is added makes every strength per unit mass smaller.
    """
    scale = experiment.amplitude / signed_amplitude(last)
    values, factors = found.of_release(0), {}
    mass = 1.0 / (1.0 + experiment.heavier)
    strengths = {str(t.strength) for t in found.model.forces if not t.force.relative}
    for unknown in found.unknowns:
        if unknown.window < 0:
            factors[unknown.name] = mass if unknown.name in strengths else 1.0
            values[unknown.name] *= factors[unknown.name]
        elif unknown.window == 0 and unknown.simulated and not unknown.whole_release:
            name = str(unknown.id.of_release(0, 1))
            values[name] *= scale
            if experiment.push and unknown.id.role == "state":
                values[name] = 0.0
    if experiment.push:
        values |= {"displacement": 0.0, "velocity": experiment.amplitude * last.frequency * np.sqrt(mass)}
    if experiment.sensor:  # its own, which is not known yet
        values |= {"gain": 1.0}
    return values, factors


def signed_amplitude(last: PreparedDecay) -> float:
    """Return the signed displacement from which a mass was let go; the largest one where the release was not recorded."""
    before = last.window.pre_release
    if before is not None and abs(before.displacement[0]) > 0.5 * last.amplitude:
        return float(before.displacement[0])
    return last.amplitude * (float(np.sign(last.motion.displacement[0])) or 1.0)


def _held_before(amplitude: float, w: float, first: float) -> PreReleaseMotion:
    """Describe a mass that is held still for a second and let go, up to the first sample that is compared (s)."""
    time = np.array([-1.0, 0.0, max(first, 1e-6)])
    angle = w * np.maximum(time, 0.0)
    return PreReleaseMotion(time, amplitude * np.cos(angle), -amplitude * w * np.sin(angle))
