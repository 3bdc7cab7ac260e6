"""Adequacy without a noise floor: power of the residual at the motion's harmonics against that between and above them.

A force that a model lacks repeats with the motion, so its residual lies at the harmonics; noise does not. The ratio of
the two powers needs no level of the noise. For an adequate model it is that of two means of squares (Fisher's F): white
noise has as much power in every bin, less what the fit's own unknowns can follow there.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.fit import Fit
from identify.formatting import three_figures
from identify.preprocessing.fit_window import FitWindow
from identify.priors import SPEAKS_AGAINST

_HARMONICS = 3
_AT, _BETWEEN = 0.08, 0.25
"""Distances from a harmonic, in units of the motion's frequency, up to which a bin is at it and from which on off it."""

_BINS_AT, _BINS_BETWEEN = 2.5, 4.0
"""The same in bins, as Hann's taper widens a line."""

_HIGHEST = 8.0
_LINE = 14.0
"""Times the median power from which on a bin between the harmonics holds a line, which is no noise."""

_INDEPENDENT = 0.52
"""Independent values a bin of a spectrum under Hann's taper."""

_FEWEST = 6


@dataclass(frozen=True)
class HarmonicResidual:
    """The ratio of a residual's power at the harmonics to that between them.

    `ratio` is that of an adequate model's expectation, 1 where nothing is left; `p_value` the probability that noise alone
    gives as much.
    """

    ratio: float
    p_value: float

    @property
    def against(self) -> bool:
        """Whether the ratio rejects the model: noise alone is very unlikely to give as much."""
        return self.p_value < SPEAKS_AGAINST

    @property
    def sentence(self) -> str:
        """Its meaning, for a record whose noise floor is a guess."""
        odds = "p < 1e-6" if self.p_value < 1e-6 else f"p = {self.p_value:.1g}"
        decides = "more than noise explains" if self.against else "no more than noise explains"
        return (
            "The noise floor is a guess here. At the motion's harmonics, what remains has "
            f"{three_figures(self.ratio)} times the power expected from the spectrum between them ({odds}): {decides}."
        )


def harmonic_residual(fit: Fit) -> HarmonicResidual | None:
    """Compare a residual's power at one, two and three times the motion's frequency with that between these.

    Of all releases together, in units of the noise, whitened where it is coloured. None where they are too short to tell.
    """
    residual, jacobian = fit.linearised
    found: list[Array] = []
    for i, window in enumerate(fit.windows):
        columns, first = np.column_stack([residual[jacobian.rows[i]], *jacobian.bases[i]]), 0
        for channel in window.channels:
            count = int(window.used[channel].sum())
            powers = _powers(window, channel, columns[first : first + count], fit.frequency)
            first += count
            if powers is not None:
                found.append(powers)
    return _compared(np.sum(found, axis=0)) if found else None


def _powers(window: FitWindow, channel: str, columns: Array, frequency: float) -> Array | None:
    """Return the power at the harmonics, the power expected there from the other bins, and their uncertainty, (5,).

    The last three are both expectations under white noise, and by how much the first may be off by an uncertain colour.
    The `columns` (used, 1 + k) are the residual and an orthonormal basis of what the fit can follow; powers are in units
    of white noise in one bin.
    """
    padded = np.zeros((len(window), columns.shape[1]))
    padded[window.used[channel]] = columns
    taper = np.hanning(len(window) - window.lead)
    bins = np.asarray(np.fft.rfftfreq(len(taper), 1.0 / window.rate), dtype=np.float64)
    at, off = _places(bins, window.rate / len(taper), window.rate, frequency / (2.0 * np.pi))
    power = np.abs(np.fft.rfft(padded[window.lead :] * taper[:, None], axis=0)) ** 2
    power /= np.sum(taper[window.used[channel][window.lead :]] ** 2)
    if int(at.sum()) < _FEWEST or int(off.sum()) < 2 * _FEWEST:
        return None
    lines = power[:, 0] > _LINE * float(np.median(power[off, 0]))
    off &= ~(lines | np.roll(lines, 1) | np.roll(lines, -1))
    if int(off.sum()) < 2 * _FEWEST:
        return None
    left, shift = 1.0 - power[:, 1:].sum(axis=1), 0.0
    expected_at, expected_off = float(left[at].sum()), float(left[off].sum())
    if channel in window.colour:
        unsure = window.colour[channel].log_error(bins, window.rate)
        shift = float(unsure[at].mean() - unsure[off].mean())
    scaled = power[off, 0].sum() * expected_at / expected_off
    return np.array([power[at, 0].sum(), scaled, expected_at, expected_off, shift * expected_at])


def _places(bins: Array, width: float, rate: float, frequency: float) -> tuple[Mask, Mask]:
    """Select the bins (Hz) at the first harmonics, and those off all harmonics, up to some harmonics above."""
    nearest = np.maximum(np.rint(bins / frequency), 1.0)
    away = np.abs(bins - nearest * frequency)
    inside = (bins > 0.5 * frequency) & (bins < min(_HIGHEST * frequency, 0.45 * rate))
    at = inside & (away <= max(_AT * frequency, _BINS_AT * width)) & (nearest <= _HARMONICS)
    off = inside & (away >= max(_BETWEEN * frequency, _BINS_BETWEEN * width))
    return at, off


def _compared(powers: Array) -> HarmonicResidual:
    """Compare the power at the harmonics with that off them, both summed over windows and channels."""
    at, scaled, expected_at, expected_off, shift = powers.tolist()
    ratio = at / scaled
    unsure = 1.0 / (_INDEPENDENT * expected_at) + (shift / expected_at) ** 2
    from scipy.special import fdtrc  # loaded when it is needed

    return HarmonicResidual(ratio, float(fdtrc(2.0 / unsure, 2.0 * _INDEPENDENT * expected_off, ratio)))
