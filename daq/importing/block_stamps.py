"""Rows that a program wrote in blocks: all rows of a block bear the time at which the block was read."""

from dataclasses import dataclass

import numpy as np

from daq.recording import Array

ROWS_A_BLOCK = 3.0
FEWEST_BLOCKS = 10
NEAR = 1.5
"""Intervals between blocks by which the reading of a block may be late: more is a hole, or no clock at all."""


@dataclass(frozen=True)
class Blocks:
    """The even clock behind block stamps: period (s) with its standard error, time of row 0 (s), rows a block."""

    period: float
    period_std: float
    start: float
    rows: float


def clock_of_blocks(time: Array) -> Blocks | None:
    """Return the even clock of rows whose stamps `time` (n,), in s and never falling, come in blocks; None when they do
    not.

    The last row of a block was sampled just before the block was read. The line through these rows is the clock; how
    far blocks stray from it gives its error.
    """
    last = np.flatnonzero(np.diff(time, append=np.inf) > 0.0)
    if len(last) < FEWEST_BLOCKS or len(time) < ROWS_A_BLOCK * len(last):
        return None
    at, stamp = last[:-1], time[last[:-1]]  # the last block may be cut off
    k, t = at - at.mean(), stamp - stamp.mean()
    spread = float(k @ k)
    period = float(k @ t) / spread
    stray = t - period * k
    interval = float(np.median(np.diff(stamp)))
    if not period > 0.0 or float(np.max(np.abs(stray))) > NEAR * interval:
        return None
    error = float(np.sqrt(stray @ stray / max(len(t) - 2, 1) / spread))
    return Blocks(period, error, float(stamp.mean() - period * at.mean()), len(time) / len(last))
