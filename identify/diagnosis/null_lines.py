"""Lines by chance: how much the best line of any frequency would lower chi-square if there were none.

A sensor's line has frequency and phase of its own in every release, so that the highest peaks of their periodograms add
up. A force's line is one for all releases and channels, in step with the clock of the release.
"""

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.fit_window import FitWindow

_AT_ONCE = 50
"""Draws that are transformed together: spectra of all would need too much memory."""

_LONGEST = 1 << 16


def rows_of(windows: tuple[FitWindow, ...]) -> list[slice]:
    """Return where the misfit of each window stands in that of all."""
    ends = np.cumsum([sum(int(m.sum()) for m in window.used.values()) for window in windows])
    return [slice(int(a), int(b)) for a, b in zip([0, *ends[:-1]], ends, strict=True)]


def line_drops(base: Fit, term: Term, noise: Array) -> Array:
    """Return the largest drop of chi-square by a line, of each draw of noise (readings, draws)."""
    parts = [noise[:, first : first + _AT_ONCE] for first in range(0, noise.shape[1], _AT_ONCE)]
    return np.concatenate(
        [_of_force(base, part) if term.is_force else _of_sensor(base, term, part) for part in parts]
    )


def _of_sensor(base: Fit, term: Term, noise: Array) -> Array:
    total = np.zeros(noise.shape[1])
    for window, rows in zip(base.windows, rows_of(base.windows), strict=True):
        spectra = _spectra(window, noise[rows], 2 * len(window))
        if term.channel in spectra:
            total += np.max(np.abs(spectra[term.channel][2:-2]) ** 2, axis=0)
    return total


def _of_force(base: Fit, noise: Array) -> Array:
    windows = base.windows
    first = min(window.time for window in windows)
    size = 2 * max(len(window) for window in windows)
    if any(window.segment for window in windows):
        span = max(window.time + len(window) / window.rate for window in windows) - first
        size = min(max(size, 2 * int(span * windows[0].rate)), _LONGEST)
    together: Array | float = 0.0
    power: Array | float = 0.0
    for window, rows in zip(windows, rows_of(windows), strict=True):
        omega = 2.0 * np.pi * np.fft.rfftfreq(size, 1.0 / window.rate)
        late = np.exp(-1j * omega * (window.time - first))
        weight = {"displacement": np.ones_like(omega), "velocity": omega * 1j, "acceleration": -(omega**2)}
        for channel, spectrum in _spectra(window, noise[rows], size).items():
            shown = np.conj(weight[channel] * late) / window.sigma[channel]
            count = int(window.used[channel].sum()) if len(windows) > 1 else 1
            together = together + np.sqrt(count) * spectrum * shown[:, None]
            power = power + count * np.abs(shown) ** 2
    peaks = np.abs(together) ** 2 / np.maximum(power, 1e-300)[:, None]
    return np.asarray(np.max(peaks[2:-2], axis=0))


def _spectra(window: FitWindow, noise: Array, size: int) -> dict[str, Array]:
    """Return the spectra, (size / 2 + 1, draws), of the noise of each channel, whose power is 2 in the mean."""
    spectra, first = {}, 0
    for channel in window.channels:
        used = window.used[channel]
        count = int(used.sum())
        padded = np.zeros((len(window), noise.shape[1]))
        padded[used] = noise[first : first + count]
        first += count
        spectra[channel] = np.fft.rfft(padded, size, axis=0) / np.sqrt(max(count, 1) / 2.0)
    return spectra
