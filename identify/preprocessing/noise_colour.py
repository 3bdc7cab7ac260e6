"""The colour of a channel's noise, as its rest shows it: a power law, a random walk or a band beside the white part; lines.

For one shape of spectrum the covariance of the readings is I + q T; in the eigenvectors of T, offset and steady drift left
out, the likelihood of every strength q is a sum over readings (restricted maximum likelihood, Patterson and Thompson 1971).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Self

import numpy as np

from identify.arrays import Array, frozen
from identify.preprocessing.noise import steps_between
from identify.signal.coloured_noise import Component, autocovariance, spectrum
from identify.signal.smoothing import without_line

SHORTEST = 32
_LONGEST = 384
_FEWEST_LEVELS = 5
_REFERENCE = 1.0 / 64.0
"""Frequency over the sampling rate at which the strength of a colour is stated."""

_CORNERS = tuple(0.25 * 4.0**-i for i in range(8))
"""Corners over the sampling rate of the processes that make up a power law, and the lowest for a random walk."""

_POWERS = (1.0, 1.5)
_BANDS = (1.0 / 200.0, 1.0 / 50.0, 1.0 / 12.0)
"""Corners over the sampling rate of noise that is flat up to them."""

STRENGTHS = frozen(np.concatenate([[0.0], np.geomspace(1e-2, 1e5, 43)]))
COLOURED = 3.5
"""Gain in log-likelihood from which on noise counts as coloured: 1 in 100 of white ones gains as much."""

UNLIKE = 2.5
"""Log-likelihood within which two shapes count as alike."""

_MOST_LINES = 4
_LINE = 4.6
"""Log-likelihood beyond the logarithm of the number of frequencies that a line must bring: chance does in 1 of 100."""

_CLEAR_OF = 1.5
_SAME = 4.0
"""Standard errors within which two frequencies are one."""


@dataclass(frozen=True)
class Shape:
    """The shape of a spectrum above the white noise, as processes whose spectrum is 1 at the reference frequency.

    Frequencies are in cycles a reading of the record that it was looked for in.
    """

    name: str
    processes: tuple[Component, ...]

    def of_strength(self, strength: float, rate: float) -> tuple[Component, ...]:
        """Return the processes in Hz, `strength` times as dense as the white noise at the reference frequency."""
        if not strength > 0.0:
            return ()
        return tuple(Component(strength * p.variance, rate * p.corner) for p in self.processes)


def _shape(name: str, processes: list[Component]) -> Shape:
    density = float(sum(p.spectrum(np.array([_REFERENCE]), 1.0)[0] for p in processes))
    return Shape(name, tuple(replace(p, variance=p.variance / density) for p in processes))


SHAPES = (
    *(_shape(f"1/f^{p:g}", [Component(c ** (1.0 - p), c) for c in _CORNERS]) for p in _POWERS),
    _shape("random walk", [Component(1.0, _CORNERS[-1])]),
    *(_shape(f"flat below {c:.2g} of the rate", [Component(1.0, c)]) for c in _BANDS),
)


_AT_LOW = np.array([float(sum(p.spectrum(np.array([1e-3]), 1.0)[0] for p in s.processes)) for s in SHAPES])
"""Density of each shape at a thousandth of the rate."""


@dataclass(frozen=True)
class Line:
    """A line at rest: frequency and its standard error (Hz), and its mean square in units of the white noise's."""

    frequency: float
    uncertainty: float
    power: float

    def in_units_of(self, before: float, after: float) -> Self:
        """Return the line beside white noise of another standard deviation than `before`."""
        return replace(self, power=self.power * (before / max(after, 1e-300)) ** 2)


@dataclass(frozen=True, eq=False)
class RestColour:
    """The colour of a channel's noise, estimated from its rest.

    `rate` (Hz) is the record's; `log_likelihood` (shapes, strengths) that of every colour, 0 for white noise; `left` are the
    readings without lines; `lines` stand in the rest; those of them that are part of the noise, since both channels have
    them, are `common`.
    """

    rate: float
    log_likelihood: Array
    left: Array
    lines: tuple[Line, ...] = ()
    common: tuple[Line, ...] = ()


def colour_at_rest(rest: Array, rate: float) -> RestColour | None:
    """Estimate the colour of the noise from readings at rest (n,), without offset and steady drift.

    None where there are too few, or where a converter's steps are all that they show.
    Lines are taken out first: under white noise, or, where it explains the rest better, under the best colour.
    """
    values = rest[-_LONGEST:]
    values = values[np.isfinite(values)]
    if len(values) < SHORTEST or len(steps_between(values)) + 1 < _FEWEST_LEVELS:
        return None
    lines, left = _without_lines(values, (), rate)
    likelihood, white = _likelihood(left)
    if_white = RestColour(rate, likelihood, left, lines)
    row, column = best(_likelihood(values)[0])
    if column == 0:
        return if_white
    components = SHAPES[row].of_strength(float(STRENGTHS[column]), rate)
    others, rest_of_it = _without_lines(values, components, rate)
    again, white_again = _likelihood(rest_of_it)
    gain = (
        white_again
        + float(again.max())
        - white
        - line_penalty(0.75 * len(values)) * (len(others) - len(lines))
    )
    if gain < COLOURED:
        return if_white
    settled = best(again)  # the first colour may have taken the lines for a part of itself
    before = white_part(rest_of_it, row, float(STRENGTHS[column]))
    after = white_part(rest_of_it, settled[0], float(STRENGTHS[settled[1]]))
    return RestColour(rate, again, rest_of_it, tuple(o.in_units_of(before, after) for o in others))


def best(log_likelihood: Array) -> tuple[int, int]:
    """Return shape and strength of the largest likelihood, by their places.

    Of shapes that are about as likely the one with most power at low frequencies: what a short record does not show of a
    slow drift is no reason to believe that there is none.
    """
    if not log_likelihood.max() > 0.0:
        return 0, int(np.argmax(log_likelihood[0]))
    return max(alike(log_likelihood), key=lambda place: STRENGTHS[place[1]] * _AT_LOW[place[0]])


def alike(log_likelihood: Array) -> list[tuple[int, int]]:
    """Return the shapes that are about as likely as the best, each at its own best strength, by their places."""
    columns = np.argmax(log_likelihood, axis=1)
    heights = log_likelihood[np.arange(len(SHAPES)), columns]
    return [(int(row), int(columns[row])) for row in np.flatnonzero(heights > heights.max() - UNLIKE)]


def log_uncertainty(log_likelihood: Array) -> float:
    """Return the standard deviation of the logarithm of a strength, from its likelihood (strengths,)."""
    weight = np.exp(log_likelihood[1:] - log_likelihood[1:].max())
    logs = np.log(STRENGTHS[1:])
    mean = float(weight @ logs / weight.sum())
    return float(np.sqrt(weight @ (logs - mean) ** 2 / weight.sum()))


def white_part(values: Array, row: int, strength: float) -> float:
    """Return the standard deviation of the white part of readings at rest (n,) without lines, whose colour is known."""
    basis, sizes = _eigen(len(values), row)
    return float(np.sqrt(np.mean((basis.T @ values) ** 2 / (1.0 + strength * sizes))))


@lru_cache(maxsize=32)
def _eigen(n: int, row: int) -> tuple[Array, Array]:
    """Return eigenvectors (n, n - 2) and eigenvalues of a shape's covariance, offset and drift projected out."""
    time = np.linspace(-1.0, 1.0, n)
    ground = np.linalg.qr(np.column_stack([np.ones(n), time]), mode="complete")[0][:, 2:]
    lags = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    covariance = autocovariance(SHAPES[row].of_strength(1.0, 1.0), np.arange(float(n)), 1.0)[lags]
    sizes, vectors = np.linalg.eigh(ground.T @ covariance @ ground)
    return frozen(ground @ vectors), frozen(np.maximum(sizes, 0.0))


def _likelihood(values: Array) -> tuple[Array, float]:
    """Return the restricted log-likelihood of every shape and strength less that of white noise, and that one."""
    table = []
    for row in range(len(SHAPES)):
        basis, sizes = _eigen(len(values), row)
        power = (basis.T @ values) ** 2
        spread = 1.0 + STRENGTHS[:, None] * sizes
        variance = np.maximum(np.mean(power / spread, axis=1), 1e-300)
        table.append(-0.5 * len(power) * np.log(variance) - 0.5 * np.log(spread).sum(axis=1))
    return np.asarray(np.array(table) - table[0][0]), float(table[0][0])


def line_penalty(frequencies: float) -> float:
    """Return the log-likelihood that a line must bring, of so many independent frequencies that it may have."""
    return float(np.log(frequencies) + _LINE)


def _without_lines(
    values: Array, components: tuple[Component, ...], rate: float
) -> tuple[tuple[Line, ...], Array]:
    """Return the lines above a background of white noise and components, and the readings without them."""
    n, clock = len(values), np.arange(len(values)) / rate
    size = 16 * n
    frequency = np.asarray(np.fft.rfftfreq(size, 1.0 / rate), dtype=np.float64)
    background = spectrum(components, frequency, rate)
    allowed = (frequency > 1.5 * rate / n) & (frequency < 0.49 * rate)
    places: list[int] = []
    left, limit = without_line(values), line_penalty(0.75 * len(values))
    columns = [np.ones(n), clock]
    found: Array = np.zeros(2)
    for _ in range(_MOST_LINES):
        power = np.abs(np.fft.rfft(left, size)) ** 2 / n / background
        variance = float(np.mean(power[allowed]))
        at = int(np.argmax(np.where(allowed, power, 0.0)))
        # what a line of two numbers takes out of n readings
        gain = -0.5 * n * np.log(max(1.0 - 2.0 * power[at] / (n * variance), 1e-6))
        if gain < limit:
            break
        f = float(frequency[at])
        places.append(at)
        columns += [np.cos(2 * np.pi * f * clock), np.sin(2 * np.pi * f * clock)]
        fitted = np.column_stack(columns)
        found = np.asarray(np.linalg.lstsq(fitted, values, rcond=None)[0], dtype=np.float64)
        left = np.asarray(values - fitted @ found, dtype=np.float64)
    if not places:
        return (), left
    white = max(float(np.mean((np.abs(np.fft.rfft(left, size)) ** 2 / n / background)[allowed])), 1e-300)
    lines = []
    for i, at in enumerate(places):  # beside the noise that all of them leave
        own = found[2 + 2 * i : 4 + 2 * i]
        strength = 0.5 * float(own @ own) / white
        error = float(np.sqrt(6.0 * background[at] / max(strength * n, 1e-9)) / np.pi * rate / n)
        lines.append(Line(float(frequency[at]), error, strength))
    return tuple(lines), left


def with_common_lines(
    colours: dict[str, RestColour], keep_off: float, moving: dict[str, tuple[Line, ...]] | None = None
) -> dict[str, RestColour]:
    """Return the channels' colours with the lines that are part of their noise.

    Those are the lines that stand in more than one channel, at rest or, by `moving`, along the motion; and of those in one
    channel alone all but the strongest, which is left to be named as that sensor's fault. Lines at rest near the frequency
    `keep_off` (Hz) or below are passed over: there the motion is.
    """
    found = dict(colours)
    for name, colour in colours.items():
        along = list((moving or {}).get(name, ()))
        others = [line for n, c in colours.items() if n != name for line in c.lines]
        common, alone = [], []
        for line in (line for line in colour.lines if line.frequency >= _CLEAR_OF * keep_off):
            same = [other for other in (*others, *along) if _is_same(line, other)]
            along = [other for other in along if other not in same]
            if same:
                common.append(_mean_of(line, same[0]))
            else:
                alone.append(line)
        common += along + sorted(alone, key=lambda line: -line.power)[1:]
        found[name] = replace(colour, common=tuple(common))
    return found


def _is_same(line: Line, other: Line) -> bool:
    apart = abs(line.frequency - other.frequency)
    return bool(apart < _SAME * np.hypot(line.uncertainty, other.uncertainty))


def _mean_of(line: Line, other: Line) -> Line:
    """Return a line with the frequency that two channels give together."""
    weights = np.array([line.uncertainty**-2, other.uncertainty**-2])
    frequency = float(weights @ np.array([line.frequency, other.frequency]) / weights.sum())
    return Line(frequency, float(weights.sum() ** -0.5), line.power)
