"""The floor: how much misfit noise alone explains, and how well that is known."""

from dataclasses import dataclass, field

import numpy as np

from identify.arrays import Array
from identify.fitting.fit import Fit
from identify.fitting.noise_colour import ChannelColour
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.noise import Noise
from identify.preprocessing.noise_colour import SHORTEST
from identify.signal.coloured_noise import Colour, Whitening, spectrum
from identify.signal.spectrum import high_band_floor

_BAND_ABOVE = 8.0
_DISAGREE = 4.0

_BAND = "band above the motion"


@dataclass(frozen=True)
class Floor:
    """Noise of each channel of one window, and what it leaves open of the reduced chi-square.

    `chi_square_std` is the standard error of a reduced chi-square of an adequate model: from the number of readings
    and from the uncertainty of the noise itself.
    """

    channels: dict[str, Noise]
    chi_square_std: float
    source: str
    colours: dict[str, ChannelColour] = field(default_factory=dict)

    def on(self, window: FitWindow) -> FitWindow:
        """Return the window with this noise."""
        return window.with_(
            sigma={c: self.channels[c].std for c in window.channels},
            colour={c: Colour(found.components, found.uncertainty) for c, found in self.colours.items()},
        )


def refine_floor(
    fit: Fit, before: tuple[dict[str, Noise], ...], colours: dict[str, ChannelColour] | None = None
) -> tuple[Floor, ...]:
    """Return the floor of each window from the noise known before and the high band of the fit's residual.

    Two estimates that agree are averaged by their errors. Where the band above the motion lies higher, what the
    model lacks leaks into it, and the estimate from before stands; where it lies lower, it is the floor. Of a channel
    whose noise is coloured (`colours`) that is the floor of its white part.
    """
    return tuple(_refine(fit, i, known, colours or {}) for i, known in enumerate(before))


def _refine(fit: Fit, i: int, known: dict[str, Noise], colours: dict[str, ChannelColour]) -> Floor:
    window = fit.windows[i]
    channels: dict[str, Noise] = {}
    share = 0.0
    total = sum(int(window.used[c].sum()) for c in window.channels)
    for channel in window.channels:
        used = window.used[channel]
        colour = colours.get(channel)
        residual = _whitened(fit, i, channel, colour)
        std, error = high_band_floor(residual, window.rate, _BAND_ABOVE * fit.frequency / (2.0 * np.pi))
        before = known[channel] if colour is None else _white_at_rest(known[channel], colour, i)
        channels[channel] = _combine(before, std, error)
        relative = channels[channel].uncertainty / channels[channel].std
        open_ = (
            2.0 * relative if colour is None else float(np.hypot(2.0 * relative, _left_open(colour, window)))
        )
        share += (int(used.sum()) / total * open_) ** 2
    spread = float(np.sqrt(2.0 / max(fit.degrees, 1) + share))
    source = "; ".join(f"{name}: {noise.source}" for name, noise in channels.items())
    return Floor(channels, spread, source, colours)


def _whitened(fit: Fit, i: int, channel: str, colour: ChannelColour | None) -> Array:
    """Return the residual of the readings that are compared, SI, whitened where it is coloured, 0 where not used."""
    window = fit.windows[i]
    used = window.used[channel]
    residual = np.where(used, fit.residual(channel, i), 0.0)
    if colour is not None:
        residual = Whitening(colour.components, window.rate, used)(residual)
    return residual[window.lead :]


def _white_at_rest(known: Noise, colour: ChannelColour, i: int) -> Noise:
    std = colour.white[i] or next((std for std in colour.white if std), None)
    if std is None:
        return known
    return Noise(std, std / np.sqrt(2.0 * SHORTEST), f"{known.source}, {colour.words}")


def _left_open(colour: ChannelColour, window: FitWindow) -> float:
    """Return what the uncertainty of a colour's strength leaves open of the reduced chi-square of its channel."""
    frequency = np.asarray(np.fft.rfftfreq(len(window), 1.0 / window.rate), dtype=np.float64)
    total = spectrum(colour.components, frequency, window.rate)
    return colour.uncertainty * float(np.mean(1.0 - spectrum(colour.lines, frequency, window.rate) / total))


def _combine(known: Noise, std: float, error: float) -> Noise:
    if not np.isfinite(error) or std <= 0.0:
        return known
    if not np.isfinite(known.uncertainty) or known.std <= 0.0:
        return Noise(std, error, _BAND)
    apart = (std - known.std) / float(np.hypot(known.uncertainty, error))
    if apart > _DISAGREE:
        return known
    if apart < -_DISAGREE:
        return Noise(std, error, _BAND)
    weights = np.array([known.uncertainty**-2, error**-2])
    mean = float(weights @ np.array([known.std, std]) / weights.sum())
    source = known.source if _BAND in known.source else f"{known.source} and {_BAND}"
    return Noise(mean, float(weights.sum() ** -0.5), source)
