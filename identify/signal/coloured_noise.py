"""Coloured noise: white noise and a few first-order processes, whitened exactly where readings are missing too.

A sum of first-order (Ornstein-Uhlenbeck) processes with corners a constant factor apart has any power law for its spectrum
(Keshner 1982); one alone is a random walk or band-limited noise, one that turns a line of slowly changing amplitude.
The Kalman filter of their sum gives the innovations, which are white (Kailath 1968).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from identify.arrays import Array, Mask
from identify.compilation import compiled


@dataclass(frozen=True)
class Component:
    """A process of one `corner` (Hz, half width of its spectrum) about a `frequency` (Hz; 0 for a drift).

    `variance` is that of a reading, in units of the white noise's.
    """

    variance: float
    corner: float
    frequency: float = 0.0

    def spectrum(self, frequency: Array, rate: float) -> Array:
        """Return its spectrum sampled at `rate` (Hz), relative to the white noise's, at frequencies in Hz."""
        keep = float(np.exp(-2.0 * np.pi * self.corner / rate))
        total = np.zeros(len(frequency))
        for side in (-1.0, 1.0):
            angle = 2.0 * np.pi * (frequency - side * self.frequency) / rate
            total += 0.5 * (1.0 - keep**2) / np.abs(1.0 - keep * np.exp(-1j * angle)) ** 2
        return np.asarray(self.variance * total)


def spectrum(components: tuple[Component, ...], frequency: Array, rate: float) -> Array:
    """Return the spectrum of white noise of density 1 and of the components together."""
    total = np.ones(len(frequency))
    for component in components:
        total += component.spectrum(frequency, rate)
    return total


def autocovariance(components: tuple[Component, ...], lags: Array, rate: float) -> Array:
    """Return the covariance of the components at lags in readings (n,), in units of the white noise's variance."""
    total = np.zeros(len(lags))
    for c in components:
        time = np.abs(lags) / rate
        total += (
            c.variance * np.exp(-2.0 * np.pi * c.corner * time) * np.cos(2.0 * np.pi * c.frequency * time)
        )
    return total


@dataclass(frozen=True)
class Colour:
    """The processes beside the white part of a noise, and the standard error of the logarithm of their strength.

    Lines are known better than that, and keep theirs.
    """

    components: tuple[Component, ...]
    uncertainty: float = 0.0

    @property
    def lines(self) -> tuple[Component, ...]:
        """The lines among them."""
        return tuple(c for c in self.components if c.frequency)

    def log_error(self, frequency: Array, rate: float) -> Array:
        """Return the standard error of the logarithm of the spectrum at frequencies in Hz."""
        total = spectrum(self.components, frequency, rate)
        return np.asarray(self.uncertainty * (1.0 - spectrum(self.lines, frequency, rate) / total))

    def beside_white(self, variance: float) -> "Colour":
        """Return the same processes beside a white part whose variance has changed by a factor."""
        return replace(
            self, components=tuple(replace(c, variance=c.variance / variance) for c in self.components)
        )


@dataclass(frozen=True, eq=False)
class Whitening:
    """The filter that turns such noise, sampled at `rate` (Hz) where `used` (n,), into white noise of variance 1."""

    components: tuple[Component, ...]
    rate: float
    used: Mask

    @cached_property
    def _model(self) -> tuple[Array, Array, Array]:
        """Return transition (m, m), observation (m,) and stationary variances (m,) of the states."""
        size = sum(2 if c.frequency else 1 for c in self.components)
        transition, seen, variance = np.zeros((size, size)), np.zeros(size), np.zeros(size)
        at = 0
        for c in self.components:
            keep = np.exp(-2.0 * np.pi * c.corner / self.rate)
            angle = 2.0 * np.pi * c.frequency / self.rate
            seen[at], variance[at] = 1.0, c.variance
            if c.frequency:
                turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
                transition[at : at + 2, at : at + 2] = keep * turn
                variance[at + 1] = c.variance
                at += 2
            else:
                transition[at, at] = keep
                at += 1
        return transition, seen, variance

    @cached_property
    def _filter(self) -> tuple[Array, Array]:
        gains, scale = _gains(*self._model, np.ascontiguousarray(self.used))
        return gains, scale

    def __call__(self, values: Array) -> Array:
        """Return values (n,) or (n, k), in units of the white noise, whitened; 0 where not used."""
        transition, seen, _ = self._model
        gains, scale = self._filter
        columns = np.ascontiguousarray(values.reshape(len(values), -1), dtype=float)
        out = _innovations(transition, seen, gains, scale, np.ascontiguousarray(self.used), columns)
        return np.asarray(out.reshape(values.shape))


@compiled()
def _gains(transition, seen, variance, used):  # type: ignore[no-untyped-def]
    """Return the gains (n, m) of the filter and one over the standard deviation of each innovation (n,)."""
    n, m = len(used), len(seen)
    gains, scale = np.zeros((n, m)), np.zeros(n)
    p, moved = np.zeros((m, m)), np.zeros((m, m))
    left, shown = np.zeros(m), np.zeros(m)
    for j in range(m):
        p[j, j] = variance[j]
        left[j] = variance[j]
        for k in range(m):
            left[j] -= variance[j] * transition[j, k] ** 2
    for i in range(n):
        if used[i]:
            size = 1.0
            for j in range(m):
                shown[j] = 0.0
                for k in range(m):
                    shown[j] += p[j, k] * seen[k]
                size += seen[j] * shown[j]
            for j in range(m):
                gains[i, j] = shown[j] / size
                for k in range(m):
                    p[j, k] -= shown[j] * shown[k] / size
            scale[i] = 1.0 / np.sqrt(size)
        for j in range(m):
            for k in range(m):
                moved[j, k] = 0.0
                for o in range(m):
                    moved[j, k] += transition[j, o] * p[o, k]
        for j in range(m):
            for k in range(m):
                total = 0.0
                for o in range(m):
                    total += moved[j, o] * transition[k, o]
                p[j, k] = total
            p[j, j] += left[j]
    return gains, scale


@compiled()
def _innovations(transition, seen, gains, scale, used, values):  # type: ignore[no-untyped-def]
    n, m = gains.shape
    out = np.zeros(values.shape)
    for column in range(values.shape[1]):
        state = np.zeros(m)
        moved = np.zeros(m)
        for i in range(n):
            if used[i]:
                error = values[i, column]
                for j in range(m):
                    error -= seen[j] * state[j]
                out[i, column] = error * scale[i]
                for j in range(m):
                    state[j] += gains[i, j] * error
            for j in range(m):
                total = 0.0
                for k in range(m):
                    total += transition[j, k] * state[k]
                moved[j] = total
            for j in range(m):
                state[j] = moved[j]
    return out
