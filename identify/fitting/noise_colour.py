"""The colour of each channel's noise, from the rest before the releases and from what a fit leaves between the harmonics.

A rest of a second says little of the noise at the motion's frequency; the residual of a good model says more. What a model
lacks stands at the harmonics of the motion, and noise does not know them: only a residual whose spectrum is as smooth at the
harmonics as between them is taken for noise.
"""

from dataclasses import dataclass

import numpy as np

from identify.arrays import Array, Mask
from identify.fitting.common_lines import common_lines, further_lines
from identify.fitting.fit import Fit
from identify.preprocessing.noise_colour import (
    COLOURED,
    SHAPES,
    STRENGTHS,
    UNLIKE,
    Line,
    RestColour,
    Shape,
    alike,
    best,
    log_uncertainty,
    white_part,
    with_common_lines,
)
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.coloured_noise import Component, spectrum

_BETWEEN = 0.25
"""Distance from a harmonic, in units of the motion's frequency, from which on a bin counts as between."""

_HARMONICS = 3
_INDEPENDENT = 0.52
"""Independent values a bin of a spectrum under Hann's taper."""

_LINE, _LINE_BINS = 14.0, 6
_FEWEST = 24
_SMOOTH = 3.5
"""Standard errors by which the power at the harmonics may lie above that of the noise."""

_VETO = 8.0
"""Log-likelihood by which a rest may disagree with a colour."""


@dataclass(frozen=True, eq=False)
class ChannelColour:
    """The colour of one channel's noise in all releases.

    `components` are in units of the white part's variance; `uncertainty` is the standard error of the logarithm of their
    strength; `white` the standard deviation of the white part of each release's rest, None where none was recorded.
    """

    shape: Shape | None
    strength: float
    uncertainty: float
    rate: float
    lines: tuple[Component, ...]
    white: tuple[float | None, ...]

    @property
    def components(self) -> tuple[Component, ...]:
        """All processes beside the white part."""
        return (*self.of_strength(self.strength), *self.lines)

    def of_strength(self, strength: float) -> tuple[Component, ...]:
        """Return the processes without the lines, at another strength."""
        return () if self.shape is None else self.shape.of_strength(strength, self.rate)

    @property
    def words(self) -> str:
        """What it is, as part of a sentence."""
        parts = [] if self.shape is None else [f"coloured, {self.shape.name}"]
        return ", ".join([*parts, *(f"a line at {line.frequency:.4g} Hz" for line in self.lines)])


def noise_colours(decays: tuple[PreparedDecay, ...], fit: Fit) -> dict[str, ChannelColour]:
    """Return the colour of each channel whose noise is not white."""
    hum = [_hum(prepared, fit, i) for i, prepared in enumerate(decays)]
    rests = [_rests_of(prepared, lines) for prepared, lines in zip(decays, hum, strict=True)]
    found = {}
    for channel in fit.windows[0].channels:
        colour = _colour(fit, channel, [rest.get(channel) for rest in rests], hum[0].get(channel, ()))
        if colour is not None:
            found[channel] = colour
    return found


def _hum(prepared: PreparedDecay, fit: Fit, i: int) -> dict[str, tuple[Line, ...]]:
    """Return the lines along the motion that are noise of their channels, where a rest does not show those of each.

    There was none, or a converter's steps hide what is less. They are hum in both channels; and in a channel of which the
    model names a line, the others: of several lines the strongest is a fault.
    """
    if all(channel in prepared.rest_colour for channel in prepared.window.channels):
        return {}
    found = common_lines(fit, i)
    named = {term.channel for term in fit.model.faults if term.effect.line}
    own = {c: found.get(c) or further_lines(fit, i, c) for c in prepared.window.channels if c in named}
    return found | own


def _rests_of(prepared: PreparedDecay, hum: dict[str, tuple[Line, ...]]) -> dict[str, RestColour]:
    colours = {c: r for c, r in prepared.rest_colour.items() if c in prepared.window.readings}
    return with_common_lines(colours, prepared.frequency / (2.0 * np.pi), hum)


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
    white = tuple(white_part(rest.left, row, strength) if rest is not None else None for rest in rests)
    return ChannelColour(
        SHAPES[row] if coloured else None,
        strength,
        log_uncertainty(table[row]) if coloured else 0.0,
        rate,
        lines,
        white,
    )


def _beside(rest: RestColour, row: int, column: int) -> tuple[Line, ...]:
    """Return the common lines of a rest in units of the white part that a colour leaves, not of the rest's own."""
    own = best(rest.log_likelihood)
    before = white_part(rest.left, own[0], float(STRENGTHS[own[1]]))
    after = white_part(rest.left, row, float(STRENGTHS[column]))
    return tuple(line.in_units_of(before, after) for line in rest.common)


def _of_residual(fit: Fit, channel: str, rate: float, at_rest: Array) -> Array:
    """Return what the residuals say of every colour, (shapes, strengths); 0 where they are not taken for noise."""
    total = np.zeros_like(at_rest)
    for i in range(len(fit.windows)):
        bins = _bins(fit, i, channel)
        if bins is None:
            continue
        frequency, power, between, harmonic = bins
        backgrounds = np.array(
            [spectrum(shape.of_strength(1.0, rate), frequency, fit.windows[i].rate) - 1.0 for shape in SHAPES]
        )
        spread = 1.0 + STRENGTHS[:, None] * backgrounds[:, None, between]
        variance = np.maximum(np.mean(power[between] / spread, axis=2), 1e-300)
        own = -_INDEPENDENT * (int(between.sum()) * np.log(variance) + np.log(spread).sum(axis=2))
        own -= own[0, 0]
        places = alike(own + at_rest)
        models = [variance[r, c] * (1.0 + STRENGTHS[c] * backgrounds[r]) for r, c in places]
        smooth = [
            _is_smooth(power, model, harmonic, between) and _is_allowed(at_rest, *place)
            for place, model in zip(places, models, strict=True)
        ]
        if any(smooth):  # one shape that it can be is enough; the others are out
            own[[row for (row, _), good in zip(places, smooth, strict=True) if not good]] -= UNLIKE
            total += own
    return total


def _is_allowed(at_rest: Array, row: int, column: int) -> bool:
    """Whether the rest could be of this colour: a residual above what was seen at rest is misfit."""
    return bool(at_rest.max() - at_rest[row, column] < _VETO)


def _is_smooth(power: Array, model: Array, near: Mask, between: Mask) -> bool:
    """Whether a residual has no more power near the harmonics than its colour would give it, and no line."""
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
    time = np.linspace(-1.0, 1.0, n)
    residual = residual - np.polynomial.polynomial.polyval(
        time, np.polynomial.polynomial.polyfit(time, residual, 1)
    )
    taper = np.hanning(n)
    power = np.abs(np.fft.rfft(residual * taper)) ** 2 / np.sum(taper**2)
    frequency = np.asarray(np.fft.rfftfreq(n, 1.0 / window.rate), dtype=np.float64)
    f0, width = fit.frequency / (2.0 * np.pi), window.rate / n
    order = frequency / f0
    nearest = np.maximum(np.rint(order), 1.0)
    off = np.abs(order - nearest)
    inside = (frequency > 2.5 * width) & (frequency < 0.49 * window.rate)
    between = inside & (off * f0 > max(_BETWEEN * f0, 3.0 * width))
    harmonic = inside & ~between & (nearest <= _HARMONICS)
    for _ in range(8):
        level = np.median(power[between]) / np.log(2.0) if between.any() else 0.0
        high = np.flatnonzero(between & (power > _LINE * level) & (frequency > 2.5 * f0))
        if len(high) == 0:
            break
        at = high[int(np.argmax(power[high]))]
        between[max(at - _LINE_BINS, 0) : at + _LINE_BINS + 1] = False
    return (frequency, power, between, harmonic) if int(between.sum()) >= _FEWEST else None
