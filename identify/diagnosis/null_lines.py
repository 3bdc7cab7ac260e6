"""Lines by chance: how much the best line of any frequency would lower chi-square if there were none.

A sensor's line has frequency and phase of its own in every release, so that the highest peaks of their periodograms add
up. A force's line is one for all releases and channels, in step with the clock of the release.
"""

from dataclasses import dataclass

import numpy as np
from scipy.fft import next_fast_len, rfft

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.model.model import Term
from identify.preprocessing.fit_window import FitWindow

_AT_ONCE = 1_500_000
"""Numbers that are transformed together: spectra of all draws would need too much memory."""

_LONGEST = 1 << 16

_ONE_CLOCK = 1e-6
"""Share of a sample by which two windows of one record may seem to be off its samples."""


def rows_of(windows: tuple[FitWindow, ...]) -> list[slice]:
    """Return where the misfit of each window stands in that of all."""
    ends = np.cumsum([sum(int(m.sum()) for m in window.used.values()) for window in windows])
    return [slice(int(a), int(b)) for a, b in zip([0, *ends[:-1]], ends, strict=True)]


def line_drops(base: Fit, term: Term, noise: Array) -> Array:
    """Return the largest drop of chi-square by a line, of each draw of noise (readings, draws)."""
    size = _size(base.windows) if term.is_force else 2 * max(len(window) for window in base.windows)
    many = max(_AT_ONCE // size, 1)
    parts = [noise[:, first : first + many] for first in range(0, noise.shape[1], many)]
    return np.concatenate(
        [_of_force(base, part, size) if term.is_force else _of_sensor(base, term, part) for part in parts]
    )


def _of_sensor(base: Fit, term: Term, noise: Array) -> Array:
    total = np.zeros(noise.shape[1])
    for window, rows in zip(base.windows, rows_of(base.windows), strict=True):
        if term.channel in window.channels:
            total += highest(_power(window, term.channel, noise[rows]))
    return total


def _power(window: FitWindow, channel: str, noise: Array) -> Array:
    """Return the periodogram of each draw of the noise of one window, (frequencies, draws), the first of the third bin."""
    padded = np.zeros((len(window), noise.shape[1]))
    padded[window.used[channel]] = _scaled(window, noise)[channel]
    return np.asarray(np.abs(np.fft.rfft(padded, 2 * len(window), axis=0)[2:-2]) ** 2)


@dataclass(frozen=True)
class Line:
    """A line as a channel shows it: frequency (Hz), size (of the reading) and phase at the release (rad)."""

    channel: str
    values: tuple[float, float, float]


def likeliest_line(base: Fit, term: Term, misfit: Array) -> Line:
    """Return the line that lowers a misfit (readings, 1) most, as the first release shows it.

    That is the highest peak of what `line_drops` takes of the draws. A residual's strongest lines (`residual_lines`), seen
    through a window that keeps the motion's leaks away, are others where all is noise.
    """
    window = base.windows[0]
    if term.is_force:
        size, channel = _size(base.windows), window.channels[0]
        power = _power_of_force(base, misfit, size)
    else:
        size, channel = 2 * len(window), term.channel
        power = _power(window, channel, misfit[rows_of(base.windows)[0]])
    frequency = _top(power[:, 0], window.rate / size)
    used = window.used[channel]
    angle = 2.0 * np.pi * frequency * window.clock[used]
    waves = np.column_stack([np.sin(angle), np.cos(angle)])
    sine, cosine = np.linalg.lstsq(waves, base.residual(channel, 0)[used], rcond=None)[0]
    return Line(
        channel, (frequency, float(np.hypot(sine, cosine)), float(np.arctan2(cosine, sine) % (2.0 * np.pi)))
    )


def _top(power: Array, step: float) -> float:
    """Return the frequency (Hz) of the highest peak of a periodogram that begins at its third bin."""
    at = int(np.argmax(power))
    shift = 0.0
    if 0 < at < len(power) - 1:
        left, top, right = power[at - 1 : at + 2]
        bend = left - 2.0 * top + right
        shift = 0.5 * (left - right) / bend if bend < 0.0 else 0.0
    return float((at + 2 + shift) * step)


def _size(windows: tuple[FitWindow, ...]) -> int:
    """Return the length of the transform that resolves a line through all windows.

    That of pieces of a long record is the next that has small factors only: one with a large prime takes ten times as long.
    """
    first = min(window.time for window in windows)
    size = 2 * max(len(window) for window in windows)
    if any(window.segment for window in windows):
        span = max(window.time + len(window) / window.rate for window in windows) - first
        size = int(next_fast_len(max(size, 2 * int(span * windows[0].rate)), real=True))
        size = min(size, _LONGEST)
    return size


def _of_force(base: Fit, noise: Array, size: int) -> Array:
    return highest(_power_of_force(base, noise, size))


def _power_of_force(base: Fit, noise: Array, size: int) -> Array:
    """Return the drop of chi-square by a line of each frequency, (frequencies, draws), the first of the third bin.

    Add up the spectra of all windows at their times; pieces of one record, whose samples have one clock, as one."""
    windows = base.windows
    start = min(window.time for window in windows)
    together, power = np.zeros((size // 2 + 1, noise.shape[1]), dtype=complex), np.zeros(size // 2 + 1)
    rows = rows_of(windows)
    for pieces in _records(windows):
        first = windows[pieces[0]]
        omega = 2.0 * np.pi * np.fft.rfftfreq(size, 1.0 / first.rate)
        late = np.exp(-1j * omega * (first.time - start))
        weight = {"displacement": np.ones_like(omega), "velocity": omega * 1j, "acceleration": -(omega**2)}
        for channel in first.channels:
            record = np.zeros((size, noise.shape[1]))
            for i in pieces:
                window = windows[i]
                at = round((window.time - first.time) * first.rate) + np.flatnonzero(window.used[channel])
                count = len(at) if len(windows) > 1 else 1
                values = _scaled(window, noise[rows[i]])[channel]
                record[at % size] += np.sqrt(count) / window.sigma[channel] * values
                power += count / window.sigma[channel] ** 2 * np.abs(weight[channel]) ** 2
            together += rfft(record, axis=0) * (np.conj(weight[channel]) * late)[:, None]
    peaks = np.abs(together) ** 2 / np.maximum(power, 1e-300)[:, None]
    return np.asarray(peaks[2:-2])


def highest(power: Array) -> Array:
    """Return the top of the highest peak of each column (places, draws), which may lie between two places; (draws,).

    A parabola through the peak and its neighbours adds a quarter at most.
    """
    if len(power) < 3:
        return np.asarray(np.max(power, axis=0))
    at = np.clip(np.argmax(power, axis=0), 1, len(power) - 2)
    each = np.arange(power.shape[1])
    left, top, right = (power[at + step, each] for step in (-1, 0, 1))
    bend = 2.0 * top - left - right
    rise = np.where(bend > 0.0, (right - left) ** 2 / (8.0 * np.where(bend > 0.0, bend, 1.0)), 0.0)
    return np.asarray(np.maximum(np.max(power, axis=0), top + np.minimum(rise, 0.25 * top)))


def _records(windows: tuple[FitWindow, ...]) -> list[list[int]]:
    """Return the windows in groups whose samples lie on one clock: the pieces of each record."""
    groups: list[list[int]] = []
    for i, window in enumerate(windows):
        for group in groups:
            first = windows[group[0]]
            apart = (window.time - first.time) * first.rate
            alike = window.rate == first.rate and window.channels == first.channels
            if alike and abs(apart - round(apart)) < _ONE_CLOCK and apart > 0.0:
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _scaled(window: FitWindow, noise: Array) -> dict[str, Array]:
    """Return the noise of each channel at its used readings, (used, draws), scaled to a power of 2 in all in the mean."""
    found, first = {}, 0
    for channel in window.channels:
        count = int(window.used[channel].sum())
        found[channel] = noise[first : first + count] / np.sqrt(max(count, 1) / 2.0)
        first += count
    return found
