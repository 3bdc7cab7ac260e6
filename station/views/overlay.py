"""Both channels on one footing, and close to a zero of the acceleration, where a lag shows most."""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array
from station.story.pipeline import Identification
from station.views.figure import Picture, figure, literal
from station.views.palette import LIGHT, Look

PERIOD_SHARE = 0.05
TAIL = 7.0
NEAR = 0.06
"""Share of the period that is shown about a zero."""


@dataclass(frozen=True, eq=False)
class Overlay:
    """Acceleration and twice differentiated displacement under the same filter, m/s^2, on `time` (s)."""

    time: Array
    acceleration: Array
    before: Array
    after: Array


def overlay(result: Identification) -> Overlay | None:
    """Put both channels on one footing: the same Gaussian smooths one and differentiates the other twice.

    None without a displacement and an acceleration.
    """
    from scipy.ndimage import gaussian_filter1d

    recorded, aligned = result.decay, result.aligned
    if recorded.acceleration is None or recorded.displacement is None or aligned.displacement is None:
        return None
    width = max(1.5, PERIOD_SHARE * _period(result) * recorded.rate)
    edge = int(TAIL * width) + 1
    if 4 * edge >= len(recorded):
        return None
    inside = slice(edge, len(recorded) - edge)

    def second_derivative(displacement: Array) -> Array:
        smooth: Array = gaussian_filter1d(displacement, width, order=2, truncate=TAIL) * recorded.rate**2
        return smooth[inside]

    return Overlay(
        recorded.time[inside],
        gaussian_filter1d(recorded.acceleration, width, truncate=TAIL)[inside],
        second_derivative(recorded.displacement),
        second_derivative(aligned.displacement),
    )


def _period(result: Identification) -> float:
    found = result.restoring_force or result.wavelet
    stiffness = 0.0 if found is None else found.stiffness_per_mass.value
    return float(2 * np.pi / np.sqrt(stiffness)) if stiffness > 0 else 0.0


def alignment(result: Identification, look: Look = LIGHT) -> Picture | None:
    """Draw both channels as accelerations about a zero one period after the release, as recorded and with the lag corrected.

    None without both channels, or such a zero.
    """
    seen, rate = overlay(result), result.decay.rate
    if seen is None or result.alignment is None:
        return None
    period = _period(result) or 10 / rate
    later = np.flatnonzero(seen.time > result.release.settle / rate + period)
    crossings = np.flatnonzero(np.diff(np.sign(seen.acceleration[later])) > 0)
    if not len(crossings):
        return None
    time = seen.time - seen.time[later[crossings[0]]]
    near = np.abs(time) < max(NEAR * period, 4 / rate)
    ms, gain = time[near] * 1e3, result.alignment.gain.value
    drawn, axes = figure(look, 2.1, 1, 2, sharey=True)
    for axis, second, title in zip(
        axes, (seen.before, seen.after), ("as recorded", "lag corrected"), strict=True
    ):
        axis.plot(ms, seen.acceleration[near], "o-", color=look.second, ms=4, label="acceleration")
        axis.plot(
            ms, gain * second[near], "x--", color=look.model, ms=4.5,
            label="displacement, twice\ndifferentiated",
        )  # fmt: skip
        axis.set(title=title, xlabel="time about a zero of the acceleration [ms]")
    axes[0].set_ylabel(literal(f"acceleration [{result.decay.unit}/s^2]"))
    axes[0].legend(loc="upper left")
    return drawn
