"""Phase drift: whether a long decay keeps in step with itself, or a clock, a warming or a draught moves its phase.

Whatever forces act, the frequency of a free decay is a function of its amplitude, and if they change, they change
slowly. Cycle by cycle, the phase less the integral of such a function is the noise of the readings, or it drifts.
"""

import numpy as np

from identify.arrays import Array
from identify.preprocessing.prepared_decay import PreparedDecay

_POWERS = (1.0, 2.0, 4.0, -1.0)
"""Of the amplitude, in the frequency: one-sided and hysteretic springs, cubic, quintic, play; dry friction has no share."""

_ENDS = 2
"""Cycles at either end of the motion that are not looked at."""

_NORMAL = 0.6745
"""Median of a standard normal variable's size: a jump of the phase is no drift."""

_SHARE_OF_NOISE = 0.3
"""A drift that moves the readings by this share of their noise raises a reduced chi-square by a twentieth."""


def drifts(prepared: PreparedDecay) -> bool:
    """Return whether the phase strays from every law of the amplitude by more than a share of the readings' noise."""
    phase, amplitude = _phase_by_cycle(prepared)
    if len(phase) <= len(_POWERS) + 3:  # as many as the law has coefficients: nothing is left to stray
        return False
    cycles = np.arange(len(phase), dtype=np.float64)
    relative = amplitude / amplitude.max()
    columns = [np.ones_like(cycles), cycles, cycles**2]
    columns += [np.cumsum(relative**power) - 0.5 * relative**power for power in _POWERS]
    design = np.column_stack(columns) * relative[:, None]
    design /= np.linalg.norm(design, axis=0)
    left = phase * relative
    left = (left - design @ np.linalg.lstsq(design, left, rcond=1e-10)[0]) * amplitude.max()
    noise = _noise(prepared)
    by_cycle = 2.0 * noise**2 / _samples_a_cycle(prepared)
    strays = float(np.median(np.abs(left))) / _NORMAL
    return bool(strays**2 > by_cycle + (_SHARE_OF_NOISE * noise) ** 2)


def _phase_by_cycle(prepared: PreparedDecay) -> tuple[Array, Array]:
    """Return the mean phase (rad) beyond that of a steady rotation and the mean amplitude of each cycle, (cycles,)."""
    motion, w = prepared.motion, prepared.frequency
    quarter = motion.velocity / w
    phase = np.unwrap(np.arctan2(-quarter, motion.displacement))
    amplitude = np.hypot(motion.displacement, quarter)
    turns = np.maximum.accumulate((phase - phase[0]) / (2.0 * np.pi))
    cycle = np.floor(turns).astype(int)
    whole = cycle < cycle[-1]
    beyond = phase - w * np.arange(len(phase)) / motion.rate
    count = np.maximum(np.bincount(cycle[whole]), 1)
    inside = slice(_ENDS, -_ENDS)  # where the motion is read off both sides
    return (
        (np.bincount(cycle[whole], beyond[whole]) / count)[inside],
        (np.bincount(cycle[whole], amplitude[whole]) / count)[inside],
    )


def _samples_a_cycle(prepared: PreparedDecay) -> float:
    return 2.0 * np.pi / prepared.frequency * prepared.motion.rate


def _noise(prepared: PreparedDecay) -> float:
    """Return the noise of a reading as displacement: of the channel that knows it best."""
    sigma, w = prepared.window.sigma, prepared.frequency
    order = {"displacement": 0, "velocity": 1, "acceleration": 2}
    return min(sigma[channel] / w ** order[channel] for channel in sigma)
