"""The dominant frequency: where the spectrum of a decay peaks."""

import numpy as np
from scipy import fft

from identify.arrays import Array
from identify.errors import NotIdentifiable


def dominant_frequency(samples: Array, rate: float) -> float:
    """Return the frequency (Hz) of the highest line of the windowed, padded, interpolated spectrum.

    `samples` (n,) at `rate` Hz. Good to a small part of 1/duration; the ridge refines it. Raises
    NotIdentifiable where there is no oscillation to find.
    """
    n = len(samples)
    if n < 16:
        raise NotIdentifiable(f"only {n} samples of free motion; record a longer decay")
    time = np.linspace(-1, 1, n)
    centred = samples - np.polynomial.polynomial.polyval(
        time, np.polynomial.polynomial.polyfit(time, samples, 1)
    )
    if not np.any(np.abs(centred) > 0):
        raise NotIdentifiable("the channel does not move after the release; check the sensor")
    length = fft.next_fast_len(4 * n, real=True)
    power = np.abs(fft.rfft(centred * np.hanning(n), length)) ** 2
    lowest = max(1, int(1.5 * length / n))  # below: less than one and a half cycles in the record
    peak = lowest + int(np.argmax(power[lowest:-1]))
    if peak <= lowest:
        raise NotIdentifiable("no oscillation stands out of the record; it holds less than two cycles")
    before, at, after = np.log(power[peak - 1 : peak + 2] + 1e-300)
    shift = 0.5 * (before - after) / (before - 2 * at + after)
    return float((peak + np.clip(shift, -0.5, 0.5)) * rate / length)
