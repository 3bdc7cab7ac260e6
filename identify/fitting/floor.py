"""The floor: how much misfit noise alone explains, and how well that is known."""

from dataclasses import dataclass

import numpy as np

from identify.fitting.fit import Fit
from identify.preprocessing.fit_window import FitWindow
from identify.preprocessing.noise import Noise
from identify.signal.spectrum import high_band_floor

_BAND_ABOVE = 8.0
_DISAGREE = 4.0


@dataclass(frozen=True)
class Floor:
    """Noise of each channel of one window, and what it leaves open of the reduced chi-square.

    `chi_square_std` is the standard error of a reduced chi-square of an adequate model: from the number of readings
    and from the uncertainty of the noise itself.
    """

    channels: dict[str, Noise]
    chi_square_std: float
    source: str

    def on(self, window: FitWindow) -> FitWindow:
        """Return the window with this noise."""
        return window.with_(sigma={c: self.channels[c].std for c in window.channels})


def refine_floor(fit: Fit, before: tuple[dict[str, Noise], ...]) -> tuple[Floor, ...]:
    """Return the floor of each window from the noise known before and the high band of the fit's residual.

    Two estimates that agree are averaged by their errors. Where the band above the motion lies higher, what the
    model lacks leaks into it, and the estimate from before stands; where it lies lower, it is the floor.
    """
    return tuple(_refine(fit, i, known) for i, known in enumerate(before))


def _refine(fit: Fit, i: int, known: dict[str, Noise]) -> Floor:
    window = fit.windows[i]
    channels: dict[str, Noise] = {}
    share = 0.0
    total = sum(int(window.used[c].sum()) for c in window.channels)
    for channel in window.channels:
        used = window.used[channel]
        residual = np.where(used, fit.residual(channel, i), 0.0)[window.lead :]
        std, error = high_band_floor(residual, window.rate, _BAND_ABOVE * fit.frequency / (2.0 * np.pi))
        channels[channel] = _combine(known[channel], std, error)
        relative = channels[channel].uncertainty / channels[channel].std
        share += (int(used.sum()) / total * 2.0 * relative) ** 2
    spread = float(np.sqrt(2.0 / max(fit.degrees, 1) + share))
    source = "; ".join(f"{name}: {noise.source}" for name, noise in channels.items())
    return Floor(channels, spread, source)


def _combine(known: Noise, std: float, error: float) -> Noise:
    if not np.isfinite(error) or std <= 0.0:
        return known
    if not np.isfinite(known.uncertainty) or known.std <= 0.0:
        return Noise(std, error, "band above the motion")
    apart = (std - known.std) / float(np.hypot(known.uncertainty, error))
    if apart > _DISAGREE:
        return known
    if apart < -_DISAGREE:
        return Noise(std, error, "band above the motion")
    weights = np.array([known.uncertainty**-2, error**-2])
    mean = float(weights @ np.array([known.std, std]) / weights.sum())
    return Noise(mean, float(weights.sum() ** -0.5), f"{known.source} and band above the motion")
