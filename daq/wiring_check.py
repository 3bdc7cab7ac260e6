"""Wrong wiring by kinematics alone: a sensor reversed, channels swapped or dead, a scale that cannot be."""

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


def suspicions(displacement: Array, acceleration: Array, rate: float) -> tuple[Suspicion, ...]:
    """List the suspicions about two channels, shape (n,), that saw a free oscillation at `rate` Hz.

    About a spring's rest the acceleration opposes the displacement: a sign that does not is reversed. A
    correlation near zero means that the two measure different things. A channel that does not move at all
    says nothing of the other.
    """
    if len(displacement) < SHORTEST or not (np.ptp(displacement) and np.ptp(acceleration)):
        return ()
    with np.errstate(over="ignore", invalid="ignore"):  # a file may hold numbers near the largest
        x = displacement - displacement[-len(displacement) // 8 :].mean()
        a = acceleration - acceleration.mean()
        finite = np.isfinite((x @ x) * (a @ a))
    if not finite:
        return ()
    power = float(np.sqrt((x @ x) * (a @ a)))
    correlation = float(x @ a) / power if power > 0 else 0.0
    if correlation > 0.5:
        return (
            Suspicion(
                True,
                "displacement and acceleration have the same sign: one of them is reversed",
                "turn one sensor round, or change the sign of its scale",
            ),
        )
    if correlation > -0.5:
        return (
            Suspicion(
                False,
                f"displacement and acceleration hardly agree (correlation {correlation:.2f}, near -1 expected):"
                " swapped, or on different masses",
                "check which sensor is on which channel",
            ),
        )
    return _scales(x, a, rate)


def _scales(x: Array, a: Array, rate: float) -> tuple[Suspicion, ...]:
    """Compare a/x with the square of the frequency at which x crosses its middle."""
    big, crossings = large_motion(x)
    if crossings < 4 or len(big) < 16:
        return ()
    omega = np.pi * crossings / ((big[-1] - big[0]) / rate)
    ratio = float(np.sqrt((a @ a) / (x @ x))) / omega**2
    if 1 / SCALE_LIMIT < ratio < SCALE_LIMIT:
        return ()
    return (
        Suspicion(
            True,
            f"the acceleration is {ratio:.3g} times the value that displacement and frequency give:"
            " channels are swapped, or a scale is wrong",
            "check which sensor is on which channel, and the scales",
        ),
    )


def large_motion(x: Array) -> tuple[np.ndarray, int]:
    """Return the indices at which |x| is above a fifth of its largest, and how often x changed sides there."""
    threshold = 0.2 * np.abs(x).max()
    side = np.where(x > threshold, 1, np.where(x < -threshold, -1, 0))
    side = side[side != 0]
    return np.flatnonzero(np.abs(x) > threshold), int((side[1:] != side[:-1]).sum())
