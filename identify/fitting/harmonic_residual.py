"""Adequacy without a floor: power of a fit's residual at the motion's harmonics against that between and above them.

What a model of a motion lacks repeats with the motion, and stands at its harmonics; noise does not know them. The ratio of
the two powers needs no level of the noise. Its distribution for an adequate model is that of a ratio of two means of squares
(Fisher's F), whose degrees of freedom and mean come from drawn noise, less what the fit's own unknowns can follow.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.fit import Fit
from identify.fitting.jacobian import linearise
from identify.fitting.problem import Problem
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

_DRAWS = 100
_FEWEST = 6


@dataclass(frozen=True)
class HarmonicResidual:
    """How much more power a residual has at the harmonics than between them.

    `ratio` is that of an adequate model's expectation, 1 where nothing is left; `p_value` the probability that noise alone
    gives as much; `channels` holds the p-value of each channel by itself. A record too short to tell gives p = 1.
    """

    ratio: float
    p_value: float
    channels: dict[str, float]

    @property
    def against(self) -> bool:
        """Whether it speaks against the model: noise alone hardly ever leaves as much at the harmonics."""
        return self.p_value < SPEAKS_AGAINST

    @property
    def sentence(self) -> str:
        """What it says, for a record whose noise floor is a guess; "" where the record is too short to tell."""
        if not self.channels:
            return ""
        odds = "p < 1e-6" if self.p_value < 1e-6 else f"p = {self.p_value:.1g}"
        times = f"{three_figures(self.ratio)} times what noise of the level between them gives, {odds}"
        if self.against:
            return f"The noise floor is a guess here, but at the motion's harmonics the residual is {times}: not noise."
        return f"The noise floor is a guess here; at the motion's harmonics the residual is {times}, as noise leaves it."


def harmonic_residual(fit: Fit) -> HarmonicResidual:
    """Return the power of a fit's residual at once, twice and three times the motion's frequency, against that off them.

    Of all releases together, in units of the noise, whitened where it is coloured, with the same draws each time.
    """
    problem = Problem(fit.model, fit.windows, fit.frequency)
    residual, jacobian = linearise(problem, fit.theta)
    if not np.isfinite(residual).all():
        return HarmonicResidual(np.inf, 0.0, {})
    tangent = jacobian.tangent(np.diag(jacobian.normal()) > 0.0)
    random = np.random.default_rng(0)
    noise = np.concatenate(
        [
            *(w.draw_noise(c, random, _DRAWS) for w in fit.windows for c in w.channels),
            np.zeros((len(problem.expected), _DRAWS)),
        ]
    )
    columns = np.column_stack([residual, tangent.free(noise)])
    at: dict[str, list[Array]] = {}
    off: dict[str, list[Array]] = {}
    first = 0
    for window in fit.windows:
        for channel in window.channels:
            count = int(window.used[channel].sum())
            powers = _powers(window, channel, columns[first : first + count], fit.frequency)
            first += count
            if powers is not None:
                at.setdefault(channel, []).append(powers[0])
                off.setdefault(channel, []).append(powers[1])
    if not at:
        return HarmonicResidual(1.0, 1.0, {})
    alone = {c: _judged(np.sum(at[c], axis=0), np.sum(off[c], axis=0))[1] for c in at}
    ratio, p = _judged(
        np.sum([p for parts in at.values() for p in parts], axis=0),
        np.sum([p for parts in off.values() for p in parts], axis=0),
    )
    return HarmonicResidual(ratio, p, alone)


def _powers(window: FitWindow, channel: str, columns: Array, frequency: float) -> tuple[Array, Array] | None:
    """Return the power at the harmonics and off them of the residual and of each draw, (1 + draws,) each."""
    padded = np.zeros((len(window), columns.shape[1]))
    padded[window.used[channel]] = columns
    padded = padded[window.lead :]
    n = len(padded)
    at, off = _places(n, window.rate, frequency / (2.0 * np.pi))
    if int(at.sum()) < _FEWEST or int(off.sum()) < 2 * _FEWEST:
        return None
    power = np.abs(np.fft.rfft(padded * np.hanning(n)[:, None], axis=0)) ** 2
    lines = power[:, 0] > _LINE * float(np.median(power[off, 0]))
    off &= ~(lines | np.roll(lines, 1) | np.roll(lines, -1))
    if int(off.sum()) < 2 * _FEWEST:
        return None
    return power[at].sum(axis=0), power[off].sum(axis=0) * (at.sum() / off.sum())


def _places(n: int, rate: float, frequency: float) -> tuple[Mask, Mask]:
    """Return which bins lie at the first harmonics and which off all of them, up to some harmonics above."""
    bins = np.fft.rfftfreq(n, 1.0 / rate)
    width = rate / n
    nearest = np.maximum(np.rint(bins / frequency), 1.0)
    away = np.abs(bins - nearest * frequency)
    inside = (bins > 0.5 * frequency) & (bins < min(_HIGHEST * frequency, 0.45 * rate))
    at = inside & (away <= max(_AT * frequency, _BINS_AT * width)) & (nearest <= _HARMONICS)
    off = inside & (away >= max(_BETWEEN * frequency, _BINS_BETWEEN * width))
    return at, off


def _judged(at: Array, off: Array) -> tuple[float, float]:
    """Return the ratio of the first of two powers over its expectation, and its p-value, from the draws that follow."""
    ratio = float(at[0] / off[0] * np.mean(off[1:]) / np.mean(at[1:]))
    degrees = [2.0 * float(np.mean(p[1:]) ** 2 / np.var(p[1:])) for p in (at, off)]
    from scipy.stats import f as fisher  # costs every program half a second to load

    return ratio, float(fisher.sf(ratio, *degrees))
