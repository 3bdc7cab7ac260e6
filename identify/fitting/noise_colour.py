"""The colour of each channel's noise, from the rest before the releases and from what a fit leaves between the harmonics.

A rest of a second says little of the noise at the motion's frequency; the residual of a good model says more. What a model
lacks stands at the harmonics of the motion, and noise does not know them: only a residual whose spectrum is as smooth at the
harmonics as between them is taken for noise.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.common_lines import common_lines
from identify.fitting.fit import Fit
from identify.preprocessing.noise_colour import (
    COLOURED,
    SHAPES,
    STRENGTHS,
    UNLIKE,
    Line,
    RestColour,
    alike,
    best,
    line_penalty,
    log_uncertainty,
    white_part,
    with_common_lines,
)
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.coloured_noise import Colour, Component, spectrum
from identify.signal.smoothing import without_line

_BETWEEN = 0.25
"""Distance from a harmonic, in units of the motion's frequency, from which on a bin counts as between."""

_HARMONICS = 3
_INDEPENDENT = 0.52
"""Independent values a bin of a spectrum under Hann's taper."""

_LINE, _LINE_BINS, _MOST_LINES = 14.0, 2, 8
"""Power over that of its colour by which a bin is no noise; bins that a line fills to each side; lines at most."""

_FEWEST = 24
_SMOOTH = 3.5
"""Standard errors by which the power at the harmonics may lie above that of the noise."""

_VETO = 8.0
"""Log-likelihood by which a rest may disagree with a colour."""


@dataclass(frozen=True)
class ChannelColour(Colour):
    """The colour of one channel's noise in all releases, in units of the white part's variance.

    `name` is that of its shape, "" where it has lines only; `white` the standard deviation of the white part of each
    release's rest, None where none was recorded.
    """

    name: str = ""
    white: tuple[float | None, ...] = ()

    @property
    def words(self) -> str:
        """What it is, as part of a sentence."""
        parts = [f"coloured, {self.name}"] if self.name else []
        return ", ".join([*parts, *(f"a line at {line.frequency:.4g} Hz" for line in self.lines)])


def noise_colours(decays: tuple[PreparedDecay, ...], fit: Fit) -> dict[str, ChannelColour]:
    """Return the colour of each channel whose noise is not white."""
    hum, rests = [], []
    for i, prepared in enumerate(decays):
        seen = prepared.rest_colour
        # A channel without a rest, or with one in which a converter's steps hide smaller lines, shows hum along the motion.
        hum.append({} if all(c in seen for c in prepared.window.channels) else common_lines(fit, i))
        rests.append(with_common_lines(seen, prepared.frequency / (2.0 * np.pi), hum[i]))
    found = {}
    for channel in fit.windows[0].channels:
        colour = _colour(fit, channel, [rest.get(channel) for rest in rests], hum[0].get(channel, ()))
        if colour is not None:
            found[channel] = colour
    return found


def _colour(
    fit: Fit, channel: str, rests: list[RestColour | None], hum: tuple[Line, ...]
) -> ChannelColour | None:
    rate = next((rest.rate for rest in rests if rest is not None), fit.windows[0].rate)
    at_rest = sum((r.log_likelihood for r in rests if r is not None), np.zeros((len(SHAPES), len(STRENGTHS))))
    table = at_rest + _of_residual(fit, channel, rate, at_rest)
    row, column = best(table)
    common = next((_beside(r, row, column) for r in rests if r is not None and r.common), hum)
    lines = tuple(Component(line.power, line.uncertainty, line.frequency) for line in common)
    coloured = column > 0 and table[row, column] >= COLOURED
    if not coloured and not lines:
        return None
    strength = float(STRENGTHS[column]) if coloured else 0.0
    shape = SHAPES[row]
    white = tuple(white_part(rest.left, row, strength) if rest is not None else None for rest in rests)
    return ChannelColour(
        (*shape.of_strength(strength, rate), *lines),
        log_uncertainty(table[row]) if coloured else 0.0,
        shape.name if coloured else "",
        white,
    )


def _beside(rest: RestColour, row: int, column: int) -> tuple[Line, ...]:
    """Scale the common lines of a rest to the white part of a colour, in place of the rest's own."""
    own = best(rest.log_likelihood)
    before = white_part(rest.left, own[0], float(STRENGTHS[own[1]]))
    after = white_part(rest.left, row, float(STRENGTHS[column]))
    return tuple(line.in_units_of(before, after) for line in rest.common)


def _of_residual(fit: Fit, channel: str, rate: float, at_rest: Array) -> Array:
    """Return the log-likelihood of every colour from the residuals, (shapes, strengths); 0 where they are not noise."""
    total = np.zeros_like(at_rest)
    for i in range(len(fit.windows)):
        bins = _bins(fit, i, channel)
        if bins is None:
            continue
        frequency, power, between, harmonic = bins
        backgrounds = np.array(
            [spectrum(shape.of_strength(1.0, rate), frequency, fit.windows[i].rate) - 1.0 for shape in SHAPES]
        )
        own, variance, between = _beside_lines(power, backgrounds, between)
        places = alike(own + at_rest)
        models = [variance[r, c] * (1.0 + STRENGTHS[c] * backgrounds[r]) for r, c in places]
        smooth = [
            # a residual above the noise at rest is misfit
            _is_smooth(power, model, harmonic, between) and at_rest.max() - at_rest[place] < _VETO
            for place, model in zip(places, models, strict=True)
        ]
        if any(smooth):  # one shape that it can be is enough; the others are out
            own[[row for (row, _), good in zip(places, smooth, strict=True) if not good]] -= UNLIKE
            total += own
    return total


def _beside_lines(power: Array, backgrounds: Array, between: Mask) -> tuple[Array, Array, Mask]:
    """Return the log-likelihood of every colour beside the lines of a spectrum, its white part, and the bins without lines.

    It is relative to white noise beside lines of its own. The bins of a line count as ordinary noise of each colour, and
    a line has its price: chance brings as much, at one of so many frequencies, in 1 of 100 records.
    """
    spread = 1.0 + STRENGTHS[:, None] * backgrounds[:, None, between]
    logs, price = np.log(spread).sum(axis=2), line_penalty(len(power))

    def beside(kept: Mask, lines: int) -> tuple[Array, Array, Mask]:
        variance = np.maximum(np.mean(power[kept] / spread[:, :, kept[between]], axis=2), 1e-300)
        likelihood = -_INDEPENDENT * (int(between.sum()) * np.log(variance) + logs)
        return likelihood - lines * price, variance, kept

    paths = []
    for coloured in (False, True):  # the lines of white noise, and those of the likeliest colour
        path = [beside(between, 0)]
        for lines in range(1, _MOST_LINES + 1):
            table, _, kept = path[-1]
            row, column = best(table - table[0, 0]) if coloured else (0, 0)
            at = int(np.argmax(np.where(kept, power / (1.0 + STRENGTHS[column] * backgrounds[row]), 0.0)))
            without = kept.copy()
            without[max(at - _LINE_BINS, 0) : at + _LINE_BINS + 1] = False
            if int(without.sum()) < _FEWEST:
                break
            path.append(beside(without, lines))
        paths += path
    white = max(float(table[0, 0]) for table, _, _ in paths)
    table, variance, kept = max(paths, key=lambda one: float(one[0].max()))
    return table - white, variance, kept


def _is_smooth(power: Array, model: Array, near: Mask, between: Mask) -> bool:
    """Check that a residual has no line, and no more power near the harmonics than its colour gives."""
    count = int(near.sum())
    if count == 0:
        return False
    ratio = power / model
    if max(float(ratio[near].max()), float(ratio[between].max())) > _LINE:
        return False
    return bool(float(np.mean(ratio[near])) - 1.0 < _SMOOTH / np.sqrt(_INDEPENDENT * count))


def _bins(fit: Fit, i: int, channel: str) -> tuple[Array, Array, Mask, Mask] | None:
    """Return frequencies (Hz) and power of a residual, and which bins lie between the harmonics and which near them."""
    window = fit.windows[i]
    used = window.used[channel]
    residual = np.where(used, fit.residual(channel, i), 0.0)[window.lead :] / window.sigma[channel]
    n = len(residual)
    if not np.isfinite(residual).all() or n < 4 * _FEWEST:
        return None
    taper = np.hanning(n)
    power = np.abs(np.fft.rfft(without_line(residual) * taper)) ** 2 / np.sum(taper**2)
    frequency = np.asarray(np.fft.rfftfreq(n, 1.0 / window.rate), dtype=np.float64)
    f0, width = fit.frequency / (2.0 * np.pi), window.rate / n
    order = frequency / f0
    nearest = np.maximum(np.rint(order), 1.0)
    off = np.abs(order - nearest)
    inside = (frequency > 2.5 * width) & (frequency < 0.49 * window.rate)
    between = inside & (off * f0 > max(_BETWEEN * f0, 3.0 * width))
    harmonic = inside & ~between & (nearest <= _HARMONICS)
    return (frequency, power, between, harmonic) if int(between.sum()) >= _FEWEST else None
