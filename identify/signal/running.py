"""Running windows and runs of samples, without the twentieth of a second of loading `scipy.ndimage`."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array, Mask

Kind = TypeVar("Kind", np.float64, np.bool_)


def running_maximum(values: NDArray[Kind], width: int) -> NDArray[Kind]:
    """Return the largest of the `width` samples about each, shape (n,); at the ends of those that there are.

    Of an even width one more lies before the sample than after it.
    """
    largest, reach = np.pad(values, (width // 2, (width - 1) // 2), mode="edge"), 1
    while 2 * reach <= width:
        largest, reach = np.maximum(largest[:-reach], largest[reach:]), 2 * reach
    return np.maximum(largest[: len(values)], largest[width - reach :]) if reach < width else largest


def running_minimum(values: Array, width: int) -> Array:
    """Return the smallest of the `width` samples about each, shape (n,)."""
    return -running_maximum(-values, width)


def running_median(values: Array, width: int) -> Array:
    """Return the median of the `width` (odd) samples about each, shape (n,); the ends go on as they are."""
    windows = np.lib.stride_tricks.sliding_window_view(np.pad(values, width // 2, mode="edge"), width)
    return np.asarray(np.median(windows, axis=1))


def runs_of(mask: Mask) -> list[tuple[int, int]]:
    """Return the first sample of each run of marked samples, and one past its end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(int(first), int(stop)) for first, stop in edges.reshape(-1, 2)]
