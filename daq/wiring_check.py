"""Wrong wiring by kinematics alone: a sensor reversed, channels swapped or dead, a scale that cannot be."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from daq.recording import Array

SCALE_LIMIT = 1.75
SHORTEST = 32


@dataclass(frozen=True)
class Suspicion:
    """What speaks against a recording, and what to do about it ("" for nothing); `certain` ones reject it."""

    certain: bool
    reason: str
    advice: str = ""


def suspicions(displacement: Array, acceleration: Array, rate: float) -> Iterator[Suspicion]:
    """Yield what speaks against two channels, shape (n,), that saw a free oscillation at `rate` Hz.

    About a spring's rest the acceleration opposes the displacement: a sign that does not is reversed. A
    correlation near zero means that the two measure different things. A channel that does not move at all
    says nothing of the other.
    """
    if len(displacement) < SHORTEST or not (np.ptp(displacement) and np.ptp(acceleration)):
        return
    with np.errstate(over="ignore", invalid="ignore"):  # a file may hold numbers near the largest
        x = displacement - displacement[-len(displacement) // 8 :].mean()
        a = acceleration - acceleration.mean()
        power = float(np.sqrt((x @ x) * (a @ a)))
    if not np.isfinite(power):
        return
    correlation = float(x @ a) / power if power > 0 else 0.0
    if correlation > 0.5:
        text = "displacement and acceleration have the same sign: one of them is reversed"
        yield Suspicion(True, text, "turn one sensor round, or change the sign of its scale")
    elif correlation > -0.5:
        text = (
            f"displacement and acceleration hardly agree (correlation {correlation:.2f}, near -1 expected):"
        )
        text += " swapped, or on different masses"
        yield Suspicion(False, text, "check which sensor is on which channel")
    else:
        ratio = _ratio(x, a, rate)
        if not 1 / SCALE_LIMIT < ratio < SCALE_LIMIT:
            text = f"the acceleration is {ratio:.3g} times the value that displacement and frequency give:"
            text += " channels are swapped, or a scale is wrong"
            yield Suspicion(True, text, "check which sensor is on which channel, and the scales")


def _ratio(x: Array, a: Array, rate: float) -> float:
    """Return a/x over the square of the frequency at which x crosses its middle, while it is above a fifth of its largest.

    1 where it hardly crosses.
    """
    threshold = 0.2 * np.abs(x).max()
    big = np.flatnonzero(np.abs(x) > threshold)
    crossings = int(np.count_nonzero(np.diff(np.sign(x[big]))))
    if crossings < 4 or len(big) < 16:
        return 1.0
    omega = np.pi * crossings / ((big[-1] - big[0]) / rate)
    return float(np.sqrt((a @ a) / (x @ x)) / omega**2)
