"""Times of day that fall back by a second for a row: the program read the seconds before the fraction rolled over."""

import numpy as np

from daq.recording import Array

MOST_ROWS = 3
"""Rows in a row that may be stamped so: the time between reading seconds and fraction is short."""


def with_whole_seconds(time: Array) -> tuple[Array, int]:
    """Return times of day (n,), s, in which no row lies a second too early, and how many rows did.

    Such a row falls back by most of a second, and a second later it would lie between its neighbours.
    """
    made = time.copy()
    for at in (np.flatnonzero(np.diff(time) < -0.5) + 1).tolist():
        upto = min(at + MOST_ROWS, len(time) - 1)
        after = next((i for i in range(at + 1, upto + 1) if time[i] - time[i - 1] > 0.5), None)
        if after is None:
            continue
        later = np.concatenate([[made[at - 1]], made[at:after] + 1.0, [time[after]]])
        if np.all(np.diff(later) >= 0.0):
            made[at:after] += 1.0
    return made, int(np.count_nonzero(made != time))
