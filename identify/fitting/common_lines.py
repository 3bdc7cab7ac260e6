"""Lines that both channels show and no motion makes: where no rest was recorded, they tell hum from a force.

A motion at an angular frequency w reads a = -w^2 u in the two channels; hum that both pick up does not.
"""

import numpy as np

from identify.fitting.fit import Fit
from identify.preprocessing.fit_window import CHANNELS, FitWindow
from identify.preprocessing.noise_colour import Line
from identify.signal.spectrum import strongest_lines

_LINES = 4
_ABOVE = 2.5
"""Multiple of the motion's frequency from which on a line may be hum."""

_CLEAR = 6.0
_AT_ODDS = 0.3
"""Standard errors, and share of the line, by which two channels must contradict one motion."""

_OFF_HARMONICS = 0.2


def common_lines(fit: Fit, i: int) -> dict[str, tuple[Line, ...]]:
    """Return the lines of window i's residual that are hum in both channels, by channel."""
    window = fit.windows[i]
    if not window.paired:
        return {}
    low = window.channels[0]
    found: dict[str, tuple[Line, ...]] = {low: (), "acceleration": ()}
    lag = fit.nuisance("lag", i)
    late = 0.0 if lag is None else lag.value
    for f, amplitude, phase in _lines(fit, i, low):
        for other, other_amplitude, other_phase in _lines(fit, i, "acceleration"):
            if abs(f - other) > window.rate / len(window):
                continue
            omega = 2.0 * np.pi * f
            derivatives = CHANNELS.index("acceleration") - CHANNELS.index(low)
            moved = amplitude * np.exp(1j * (phase + omega * late)) * (1j * omega) ** derivatives
            apart = abs(other_amplitude * np.exp(1j * other_phase) - moved)
            noise = _error(window, "acceleration") + _error(window, low) * omega**derivatives
            if apart > _CLEAR * noise and apart > _AT_ODDS * max(abs(moved), other_amplitude):
                for channel, size in ((low, amplitude), ("acceleration", other_amplitude)):
                    power = 0.5 * (size / window.sigma[channel]) ** 2
                    found[channel] = (*found[channel], Line(f, 0.3 * window.rate / len(window), power))
                break
    return found


def _error(window: FitWindow, channel: str) -> float:
    """Return the standard error of a line's amplitude."""
    return window.sigma[channel] * float(np.sqrt(2.0 / max(int(window.used[channel].sum()), 1)))


def _lines(fit: Fit, i: int, channel: str) -> list[tuple[float, float, float]]:
    """Return the clear lines of a residual above the motion and off its harmonics, phases those of a sine."""
    window = fit.windows[i]
    residual = np.where(window.used[channel], fit.residual(channel, i), 0.0)[window.lead :]
    if not np.isfinite(residual).all():
        return []
    time = window.time + window.lead / window.rate
    own = fit.frequency / (2.0 * np.pi)
    return [
        (f, amplitude, phase)
        for f, amplitude, phase in strongest_lines(residual, window.rate, time, _LINES)
        if amplitude > _CLEAR * _error(window, channel)
        and f > _ABOVE * own
        and abs(f / own - round(f / own)) > _OFF_HARMONICS
    ]
