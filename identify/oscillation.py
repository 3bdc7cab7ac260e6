"""The oscillation at a glance: its frequency and how large it is, cycle by cycle, for other steps to start from."""

import numpy as np

from identify.arrays import Array


def dominant_frequency(values: Array, rate: float) -> float:
    """Return the frequency in Hz of the strongest oscillation in `values` (n,), 0.0 when there is none.

    The first difference takes the weight off a held position, a drift or a slow pull; the peak of the windowed
    periodogram is refined by the parabola through its logarithm.
    """
    n = len(values)
    if n < 8:
        return 0.0
    moving = np.diff(values)
    moving = (moving - moving.mean()) * np.hanning(n - 1)
    size = 1 << int(np.ceil(np.log2(4 * n)))
    power = np.abs(np.fft.rfft(moving, size)) ** 2
    omega = np.linspace(0.0, np.pi, len(power))
    power[1:] /= (2.0 * np.sin(omega[1:] / 2.0)) ** 2
    first = int(np.ceil(1.5 * size / n))
    power[:first] = 0.0
    if not np.any(power > 0):
        return 0.0
    peak = int(np.argmax(power))
    shift = 0.0
    if first < peak < len(power) - 1:
        left, middle, right = np.log(power[peak - 1 : peak + 2] + 1e-300)
        curvature = left - 2.0 * middle + right
        shift = 0.5 * (left - right) / curvature if curvature < 0 else 0.0
    return float((peak + shift) * rate / size)
