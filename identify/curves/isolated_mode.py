"""One isolated mode: a harmonic motion is fitted to the readings in windows of a cycle or more.

The windows are Hann's. All is linear in the reading, so that a predicted motion passes through the very same windows: what
they do to a measured motion they do to the prediction.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from identify.arrays import Array, Mask
from identify.curves.decay_curve import DecayCurve
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import initial_nuisances
from identify.fitting.problem import Problem
from identify.free_decay import CHANNELS
from identify.model.model import Model
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.fractional_delay import bridge
from identify.signal.harmonic_windows import HarmonicWindows
from identify.signal.oscillation import dominant_frequency, running_amplitude

_MOST_POINTS = 100
_HALF_WIDTHS = ((8.0, 0.75), (20.0, 1.0), (np.inf, 1.5))
"""Up to so many cycles in a record, half-width of a window in cycles."""

_RISES = 4
"""Points at the start over which the amplitude may still grow, while a hand pushes: they are left out."""

_SMALLEST = 0.03
"""Share of the largest amplitude at which a curve ends."""

_COMES_BACK = 0.1
"""Share of it to which the amplitude comes back after the node of a beat, and the curve with it."""

_SEEN = 0.5
"""Share of a window's readings, by weight, below which it says nothing and is left out."""

_TURNS = 3
_FEWEST = 4
_TOO_FEW = "The record holds too few cycles to draw a curve of."


@dataclass(frozen=True, eq=False)
class IsolatedMode:
    """The `windows` of one record, around `centre` (k,), s since the release.

    `frequency` (k,) is the angular frequency at which each looks, rad/s.
    """

    channel: str
    centre: Array
    windows: HarmonicWindows
    frequency: Array
    lightness: float

    @classmethod
    def of(cls, window: FitWindow) -> Self:
        """Lay windows over a record, following its frequency; NotIdentifiable when it holds fewer than four."""
        channel = window.channels[0]
        used = window.used[channel]
        values = bridge(window.readings[channel], used)
        mean = 2.0 * np.pi * dominant_frequency(values, window.rate, CHANNELS.index(channel))
        if not mean > 0.0:
            raise NotIdentifiable("The record shows no oscillation to draw a curve of.")
        centre, half = _centres(values, used, window.rate, mean)

        def weight(distance: Array) -> Array:
            return np.cos(0.5 * np.pi * distance / half) ** 2

        def windows(centre: Array, frequency: Array) -> HarmonicWindows:
            return HarmonicWindows.over(used, window.rate, centre, half, frequency, weight, drift=True)

        centre = centre[windows(centre, np.full(len(centre), mean)).support >= _SEEN]
        if len(centre) < _FEWEST:
            raise NotIdentifiable(_TOO_FEW)
        frequency = np.full(len(centre), mean)
        for _ in range(_TURNS):
            p, q, _ = windows(centre, frequency)(values)
            frequency = np.clip(_smoothed(frequency + (q / p).imag), 0.5 * mean, 2.0 * mean)
        whole = cls(channel, window.time + centre, windows(centre, frequency), frequency, window.lightness)
        kept = slice(int(np.argmax(whole.curve(values).amplitude[: _RISES + 1])), None)
        if len(centre[kept]) < _FEWEST:
            raise NotIdentifiable(_TOO_FEW)
        return replace(
            whole, centre=whole.centre[kept], windows=whole.windows.part(kept), frequency=frequency[kept]
        )

    def curve(self, values: Array) -> DecayCurve:
        """Compute the curve of a reading of this record, measured or predicted, (n,); lost readings may have any value."""
        values = np.where(np.isfinite(values), values, 0.0)  # no weight, but NaN times nothing is NaN
        wave, _, centre = self.windows(values)
        phase = np.angle(wave)
        expected = 0.5 * (self.frequency[1:] + self.frequency[:-1]) * np.diff(self.centre)
        turned = np.diff(phase)
        turned += 2.0 * np.pi * np.round((expected - turned) / (2.0 * np.pi))
        phase = np.concatenate([phase[:1], phase[0] + np.cumsum(turned)])
        order = CHANNELS.index(self.channel)
        size = np.maximum(np.abs(wave), 1e-300)
        square = self.windows.mean_square(values, centre) - 0.5 * size**2
        return DecayCurve(
            self.centre,
            size / self.frequency**order,
            phase - 0.5 * np.pi * order,
            centre,
            np.sqrt(np.maximum(square, 0.0)) / size,
            order == 0,
            self.lightness,
        )


def _centres(values: Array, used: Mask, rate: float, frequency: float) -> tuple[Array, float]:
    """Place the windows: their centres (k,) and half-width, s since the first sample."""
    period = 2.0 * np.pi / frequency
    running = running_amplitude(values, max(round(period * rate), 2))
    top = int(np.argmax(running))
    seen = np.convolve(used, np.ones(max(round(period * rate), 2)), "same") >= _SEEN * period * rate
    later = np.maximum.accumulate(running[top:][::-1])[::-1]
    over = (running[top:] < _SMALLEST * running[top]) & (later < _COMES_BACK * running[top])
    small = np.flatnonzero(over & seen[top:])
    end = (top + int(small[0]) if len(small) else len(values)) / rate
    cycles = end / period
    half = period * next(width for most, width in _HALF_WIDTHS if cycles <= most)
    hop = period * max(1.0, cycles / _MOST_POINTS)
    half = max(half, 0.5 * hop)
    centre = np.arange(half, end - half + 0.5 / rate, hop)
    return centre, half


def _smoothed(values: Array) -> Array:
    padded = np.concatenate([values[:1], values, values[-1:]])
    return np.convolve(padded, np.ones(3) / 3.0, "valid")


@dataclass(frozen=True, eq=False)
class Isolated:
    """One release with its windows and its measured curve; `place` among the releases that were given."""

    place: int
    decay: PreparedDecay
    mode: IsolatedMode
    curve: DecayCurve


def isolated(decays: Iterable[PreparedDecay]) -> tuple[Isolated, ...]:
    """Compute the curves of the releases with enough cycles; NotIdentifiable where none has, or one is driven."""
    found = []
    reason: NotIdentifiable | None = None
    for place, decay in enumerate(decays):
        if decay.window.force is not None:
            raise NotIdentifiable("A driven motion has no curve of its decay.")
        try:
            mode = IsolatedMode.of(decay.window)
        except NotIdentifiable as refusal:
            reason = refusal
            continue
        found.append(
            Isolated(place, decay, mode, mode.curve(np.asarray(decay.window.readings[mode.channel])))
        )
    if reason is not None and not found:
        raise reason
    return tuple(found)


_MENDED = 8
_CLOSE = 1e-4
"""Times that the start is mended, at most, and the share of the amplitude to which it then agrees."""


def simulated_curve(release: Isolated, model: Model, values: dict[str, float]) -> DecayCurve | None:
    """Simulate the curve of a model from the start of the measured one; None where the motion diverges or stops.

    `values` are the parameters of its effects by unknown's name, as if the release were the only one. The run begins
    with the measured motion under the first window, and again with its amplitude and phase corrected at the first point of
    the curve until they agree.
    """
    prepared, mode, measured = release.decay, release.mode, release.curve
    at = int(mode.windows.first[0])
    window = prepared.window.part(slice(at, None)).with_(pre_release=None)
    problem = Problem(model, (window,), prepared.frequency)
    theta = problem.theta(initial_nuisances((prepared,), model, values) | values)
    places = list(problem.layout.releases[0].start)
    theta[places] = prepared.motion.displacement[at], prepared.motion.velocity[at]
    curve = None
    for _ in range(_MENDED):
        theta = np.clip(theta, problem.low, problem.high)
        predicted = problem.read(theta, 0, problem.respond(theta, 0))[mode.channel]
        if not np.isfinite(predicted).all():
            return None
        curve = mode.curve(np.concatenate([np.zeros(at), predicted]))
        u, v = theta[places]
        state = complex(u, -v / mode.frequency[0])
        turn = np.exp(1j * (measured.phase[0] - curve.phase[0])) * measured.amplitude[0] / curve.amplitude[0]
        if abs(turn - 1.0) < _CLOSE:
            break
        theta[places] = (state * turn).real, -(state * turn).imag * mode.frequency[0]
    return curve
