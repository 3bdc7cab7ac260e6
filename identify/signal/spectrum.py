"""The spectrum of a residual: its lines and its floor."""

import numpy as np

from identify.arrays import Array


def strongest_lines(
    values: Array, rate: float, time: float, count: int
) -> tuple[tuple[float, float, float], ...]:
    """Return the strongest lines of a residual, one after the other, as (frequency Hz, amplitude, phase rad).

    A line is `amplitude sin(2 pi f t + phase)` with t counted so that the first value lies at `time` s. Each is refined
    between the bins of the spectrum and taken out before the next is looked for.
    """
    n = len(values)
    taper = np.hanning(n)
    clock = time + np.arange(n) / rate
    size = 4 * n
    frequency = np.fft.rfftfreq(size, 1.0 / rate)
    allowed = (frequency > 1.5 * rate / n) & (frequency < 0.498 * rate)
    left = values - values.mean()
    lines = []
    for _ in range(count):
        power = np.abs(np.fft.rfft(left * taper, size)) ** 2
        power[~allowed] = 0.0
        at = int(np.argmax(power))
        if power[at] <= 0.0:
            break
        f = frequency[at]
        a, b, c = np.sqrt(power[at - 1 : at + 2])
        bend = a - 2.0 * b + c
        f += 0.5 * (a - c) / bend * (frequency[1] - frequency[0]) if bend < 0.0 else 0.0
        waves = np.column_stack([np.sin(2 * np.pi * f * clock), np.cos(2 * np.pi * f * clock)])
        sine, cosine = np.linalg.lstsq(waves * taper[:, None], left * taper, rcond=None)[0]
        left = left - waves @ np.array([sine, cosine])
        lines.append((float(f), float(np.hypot(sine, cosine)), float(np.arctan2(cosine, sine) % (2 * np.pi))))
    return tuple(lines)


def white_level(power: Array, most: float) -> float:
    """Return the mean of a white spectrum's powers, lines left out: those above `most` times the mean.

    From the median on, it is that of the powers below the limit over the share that those of noise alone have of it.
    """
    floor = float(np.median(power) / np.log(2.0))
    below = 1.0 - most / float(np.expm1(most))
    for _ in range(5):
        quiet = power < most * floor
        floor = float(np.mean(power[quiet])) / below if quiet.any() else floor
    return floor


def high_band_floor(values: Array, rate: float, above: float) -> tuple[float, float]:
    """Return the white-noise standard deviation of a residual from its band above a frequency in Hz, and its standard error.

    Lines are left out of it. The error is inf when the band is empty.
    """
    n = len(values)
    taper = np.hanning(n)
    power = np.abs(np.fft.rfft((values - values.mean()) * taper)) ** 2 / np.sum(taper**2)
    power = power[np.fft.rfftfreq(n, 1.0 / rate) > above][:-1]
    if len(power) < 12:
        return 0.0, float("inf")
    std = float(np.sqrt(white_level(power, 8.0)))
    return std, std * 0.5 * np.sqrt(1.5 / len(power)) * 1.2
