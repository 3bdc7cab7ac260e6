"""Lines that both channels' residuals show and no motion makes: where no rest was recorded, they tell hum from a force.

A motion at an angular frequency w reads a = -w^2 u in the two channels; hum that both pick up does not.
"""

import numpy as np

from identify.fitting.fit import Fit
from identify.free_decay import CHANNELS
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.noise_colour import Line
from identify.signal.spectrum import strongest_lines

_LINES = 4
_ABOVE = 2.5
"""Multiple of the motion's frequency from which on a line may be hum."""

_CLEAR = 6.0
_AT_ODDS = 0.3
"""Standard errors, and share of the line, by which two channels must contradict one motion."""

_OFF_HARMONICS, _HIGHEST = 0.2, 8.0
"""Share of the motion's frequency by which a line must stand off its harmonics, up to the highest that may be seen."""

_UNSURE, _STEADY = 0.9, 0.05
"""Standard error of a line's frequency times its amplitude in errors, and the least that counts, in bins of the spectrum."""

_DYING, _HALVES = 0.6, 2.0
"""Ratio of a line in the second half of the record to that in the first below which, by so many errors, it dies."""


def common_lines(fit: Fit, i: int) -> dict[str, tuple[Line, ...]]:
    """Find the lines of window i's residual that are hum in both channels, by channel.

    A line that dies away with the motion is another mode or a harmonic, not hum.
    """
    window = fit.windows[i]
    if not window.paired:
        return {}
    low = window.channels[0]
    found: dict[str, tuple[Line, ...]] = {low: (), "acceleration": ()}
    for f in _shared(_lines(fit, i, low), _lines(fit, i, "acceleration"), window.rate / len(window)):
        seen = {channel: _phasor(fit, i, channel, f, slice(None)) for channel in found}
        if _is_no_motion(fit, i, f, seen) and not all(_dies(fit, i, channel, f) for channel in found):
            clarity = max(abs(size) / _error(window, channel) for channel, size in seen.items())
            wide = max(_STEADY, _UNSURE / clarity) * window.rate / len(window)
            for channel, size in seen.items():
                power = 0.5 * float(abs(size) / window.sigma[channel]) ** 2
                found[channel] = (*found[channel], Line(f, wide, power))
    return found


def may_be_hum(fit: Fit, channel: str, f: float) -> bool:
    """Check whether a line (Hz) of one channel's residuals lies off the motion's harmonics and lasts to each window's end.

    One that dies away with the motion is another mode.
    """
    lasts = (not _dies(fit, i, channel, f) for i in range(len(fit.windows)))
    return _stands_off(f, fit.frequency / (2.0 * np.pi)) and all(lasts)


def _shared(low: dict[float, float], high: dict[float, float], width: float) -> list[float]:
    """List the frequencies of lines that two channels have, each from the channel in which it is clearer."""
    found = []
    for f, clarity in low.items():
        near = [(other, own) for other, own in high.items() if abs(other - f) <= width]
        if near:
            other, own = max(near, key=lambda line: line[1])
            found.append(f if clarity > own else other)
    return found


def _is_no_motion(fit: Fit, i: int, f: float, seen: dict[str, complex]) -> bool:
    """Check that a line, by amplitude and phase in two channels, cannot be a motion."""
    window = fit.windows[i]
    low, high = window.channels[0], "acceleration"
    lag = fit.nuisance("lag", i)
    omega = 2.0 * np.pi * f
    derivatives = CHANNELS.index(high) - CHANNELS.index(low)
    moved = seen[low] * np.exp(1j * omega * (0.0 if lag is None else lag.value)) * (1j * omega) ** derivatives
    apart = abs(seen[high] - moved)
    noise = _error(window, high) + _error(window, low) * omega**derivatives
    return bool(apart > _CLEAR * noise and apart > _AT_ODDS * max(abs(moved), abs(seen[high])))


def _dies(fit: Fit, i: int, channel: str, f: float) -> bool:
    """Check whether a line is clearly smaller in the second half of the record than in the first."""
    window = fit.windows[i]
    middle = window.lead + (len(window) - window.lead) // 2
    first = abs(_phasor(fit, i, channel, f, slice(window.lead, middle)))
    second = abs(_phasor(fit, i, channel, f, slice(middle, None)))
    return bool(second + _HALVES * np.sqrt(2.0) * _error(window, channel) < _DYING * first)


def _phasor(fit: Fit, i: int, channel: str, f: float, samples: slice) -> complex:
    """Return the complex amplitude of a line of one frequency (Hz) in a residual, phase that of a sine at the release."""
    window = fit.windows[i]
    used = window.used[channel].copy()
    used[: window.lead] = False
    wave = np.exp(-2j * np.pi * f * window.clock[samples])
    residual = np.where(used, fit.residual(channel, i), 0.0)[samples]
    taper = np.hanning(len(residual)) * used[samples]
    return complex(2j * np.sum(taper * wave * (residual - residual.mean())) / max(float(taper.sum()), 1e-300))


def _error(window: FitWindow, channel: str) -> float:
    """Return the standard error of a line's amplitude."""
    return window.sigma[channel] * float(np.sqrt(2.0 / max(int(window.used[channel].sum()), 1)))


def _lines(fit: Fit, i: int, channel: str) -> dict[float, float]:
    """Return the clear lines of a residual above the motion and off its harmonics: Hz to amplitude in standard errors."""
    window = fit.windows[i]
    residual = np.where(window.used[channel], fit.residual(channel, i), 0.0)[window.lead :]
    if not np.isfinite(residual).all():
        return {}
    own = fit.frequency / (2.0 * np.pi)
    error = _error(window, channel)
    return {
        f: amplitude / error
        for f, amplitude, _ in strongest_lines(residual, window.rate, window.time, _LINES)
        if amplitude > _CLEAR * error and _stands_off(f, own)
    }


def _stands_off(f: float, own: float) -> bool:
    """Check whether a line (Hz) lies above a motion's own frequency (Hz) and off its harmonics."""
    return f > _ABOVE * own and (f > _HIGHEST * own or abs(f / own - round(f / own)) > _OFF_HARMONICS)
