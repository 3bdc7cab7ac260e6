"""The oscillation at a glance: its frequency and its size, cycle by cycle, for other steps to start from."""

import numpy as np

from identify.arrays import Array

NOISE_PEAK = 20.0
"""Times the median power that the highest of ten thousand frequencies of white noise exceeds in one of a hundred records."""


def dominant_frequency(values: Array, rate: float, derivative: int = 0) -> float:
    """Return the frequency in Hz of the strongest oscillation in `values` (n,), 0.0 when there is none.

    The spectrum is weighted by the frequency, which takes the weight off a held position, a drift or a slow
    pull; less so for a higher `derivative` of the displacement, which shows a blow as much as the decay. What noise
    can reach, by the level of the upper half of the band, does not count: so weighted, it would hide a slow motion. Only
    the ends are tapered, for a decay may be over early in the record. The peak is refined by the parabola
    through its logarithm.
    """
    n = len(values)
    if n < 8:
        return 0.0
    ramp = np.minimum(np.arange(n) + 1.0, n - np.arange(n)) / (0.02 * n + 1.0)
    size = 1 << int(np.ceil(np.log2(4 * n)))
    power = np.abs(np.fft.rfft((values - np.mean(values)) * np.minimum(ramp, 1.0), size)) ** 2
    first = int(np.ceil(1.5 * size / n))
    above = power > NOISE_PEAK * np.median(power[len(power) // 2 :])
    if np.any(above[first:]):
        power = np.where(above, power, 0.0)
    power *= np.linspace(0.0, 1.0, len(power)) ** (1.5 - 0.75 * derivative)
    power[:first] = 0.0
    if not np.any(power > 0):
        return 0.0
    peak = int(np.argmax(power))
    return (top_between(power, peak) if first < peak < len(power) - 1 else peak) * rate / size


def top_between(power: Array, at: int) -> float:
    """Locate a peak between the bins of a spectrum, by the parabola through its logarithm."""
    left, middle, right = np.log(np.maximum(power[at - 1 : at + 2], 1e-300))
    curvature = left - 2.0 * middle + right
    return float(at + (0.5 * (left - right) / curvature if curvature < 0.0 else 0.0))


def running_amplitude(values: Array, period: int) -> Array:
    """Return the amplitude of the oscillation of `period` samples around every sample, shape (n,).

    Demodulation under a Hann window of two periods, which is blind to a constant and nearly so to a drift. The
    first and last period hold the value next to them.
    """
    n = len(values)
    width = min(2 * period + 1, n)
    window = np.hanning(width + 2)[1:-1]
    carrier = np.exp(-2j * np.pi * np.arange(width) / period)
    kernel = window * carrier
    kernel -= window * kernel.sum() / window.sum()
    size = 1 << int(np.ceil(np.log2(n + width)))
    spread = np.fft.ifft(np.fft.fft(values - np.mean(values), size) * np.fft.fft(kernel, size))
    inside = np.abs(spread[width - 1 : n]) * 2.0 / window.sum()
    left = (n - len(inside)) // 2
    return np.pad(inside, (left, n - len(inside) - left), mode="edge")


def unfree(values: Array, period: float, noise: float, wanted: float) -> tuple[Array, float]:
    """Return the force that is not the oscillator's own, shape (n,), and its noise, in units of displacement.

    The second derivative less what value and slope explain of it over the last period, over w^2: nearly
    zero in free motion; what is left is the hand, while it holds, pulls or strikes. Derivatives are those of a
    parabola through an eighth of a period, of up to four tenths where the noise would be more than is `wanted`.
    """
    scale = 2.0 * (period / (2.0 * np.pi)) ** 2
    half, uncertainty = max(2, round(period / 16.0)) - 1, np.inf
    while uncertainty > wanted and half < max(2, round(0.2 * period)):
        half += 1
        weights = np.linalg.pinv(np.vander(np.arange(-half, half + 1.0), 3, increasing=True))
        uncertainty = noise * scale * float(np.linalg.norm(weights[2]))
    if len(values) < 4 * half + 4:
        return np.zeros(len(values)), uncertainty
    value, slope, curvature = (np.correlate(values, row, "valid") for row in weights)
    own = np.column_stack([value, slope, np.ones(len(value))])
    last = slice(-round(period), None)
    coefficients = np.linalg.lstsq(own[last], curvature[last], rcond=None)[0]
    return np.pad((curvature - own @ coefficients) * scale, half), uncertainty
