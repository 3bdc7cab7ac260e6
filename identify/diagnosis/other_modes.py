"""Other modes: decaying oscillations in the residual of a fit that are not harmonics of the motion.

A structure has more modes than the one that is followed. A second one stands in the spectrum of the residual as a line
between the harmonics, and, unlike hum or shaking from outside, dies away.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.fit import Fit
from identify.preprocessing.fit_window import FitWindow
from identify.signal.fractional_delay import bridge
from identify.signal.oscillation import dominant_frequency, top_between

_STANDS_OUT = 60.0
"""Times the median power around it from which on a line stands out of noise: 1 in 1e18 of single bins."""

_DECAYS = 0.7
"""Share of its amplitude in the first half of a record that a mode may keep in the second."""

_WORTH = 0.5
"""Amplitude in % of the motion, both in the first half, from which on a mode is told."""

_BESIDE, _BINS_BESIDE = 0.12, 2.0
"""Distance from a harmonic, in units of the motion's frequency and in bins, up to which a line is a part of it."""

_LOWEST, _HIGHEST = 0.3, 0.45
_FEWEST_BINS = 24
_MOST = 2


@dataclass(frozen=True)
class OtherMode:
    """A mode at `frequency` (Hz) beside the motion's: `percent` of the motion in one `channel` at first, decaying."""

    frequency: float
    percent: float
    channel: str

    @property
    def words(self) -> str:
        """The same in words."""
        return f"{self.frequency:.3g} Hz ({self.percent:.2g} % of the {self.channel} at first, dying away)"


def modes_sentence(modes: tuple[OtherMode, ...]) -> str:
    """Describe the other modes, and say what to do about them; "" where there are none."""
    if not modes:
        return ""
    seen = " and ".join(mode.words for mode in modes)
    return (
        f"Several modes: besides the mode of the motion the record shows {seen}. Only one mode is fitted here. Excite the "
        "others less, or filter them out, before you take the residual for a force."
    )


def other_modes(found: Fit) -> tuple[OtherMode, ...]:
    """Find the other modes in the residual of a fit's first release, the strongest first, two at most."""
    modes: list[OtherMode] = []
    window = found.windows[0]
    for channel in window.channels:
        mode = _strongest(found, window, channel)
        if mode is not None and not any(abs(mode.frequency / m.frequency - 1.0) < 0.02 for m in modes):
            modes.append(mode)
    return tuple(sorted(modes, key=lambda mode: -mode.percent)[:_MOST])


def _strongest(found: Fit, window: FitWindow, channel: str) -> OtherMode | None:
    used = window.used[channel]
    left = np.where(used, found.residual(channel, 0), 0.0)[window.lead :]
    reading = bridge(window.readings[channel], used)[window.lead :]
    half = len(left) // 2
    bins = np.asarray(np.fft.rfftfreq(half, 1.0 / window.rate), dtype=np.float64)
    free = _between_harmonics(reading[:half], window, channel, bins)
    if int(free.sum()) < _FEWEST_BINS:
        return None
    first, second = _amplitudes(left[:half]), _amplitudes(left[half : 2 * half])
    at = int(np.argmax(np.where(free, first, 0.0)))
    around = free & (bins > bins[at] / 2.0) & (bins < 2.0 * bins[at])
    stands_out = first[at] ** 2 > _STANDS_OUT * float(np.median(first[around] ** 2))
    decays = float(second[max(at - 1, 0) : at + 2].max()) < _DECAYS * first[at]
    percent = 100.0 * float(first[at]) / max(float(np.std(reading[:half])) * np.sqrt(2.0), 1e-300)
    peak = first[at] >= first[max(at - 1, 0) : at + 2].max()
    if not (stands_out and decays and peak and percent > _WORTH):
        return None
    return OtherMode(top_between(first, at) * float(bins[1]), percent, channel)


def _amplitudes(values: Array) -> Array:
    taper = np.hanning(len(values))
    return np.asarray(np.abs(np.fft.rfft((values - np.mean(values)) * taper)) * 2.0 / taper.sum())


def _between_harmonics(reading: Array, window: FitWindow, channel: str, bins: Array) -> Mask:
    """Select the bins between the harmonics of all frequencies that the motion has in this part of the record."""
    order = ("displacement", "velocity", "acceleration").index(channel)
    quarter = len(reading) // 2
    parts = (reading[:quarter], reading[quarter:], reading)
    seen = [f for part in parts if (f := dominant_frequency(part, window.rate, order)) > 0.0]
    if not seen:
        return np.zeros(len(bins), dtype=np.bool_)
    low, high = min(seen), max(seen)
    margin = max(_BESIDE * high, _BINS_BESIDE * float(bins[1]))
    free = (bins > _LOWEST * low) & (bins < _HIGHEST * window.rate)
    for n in range(int(window.rate / (2.0 * low)) + 1):
        free &= (bins < n * low - margin) | (bins > n * high + margin)
    return np.asarray(free, dtype=np.bool_)
