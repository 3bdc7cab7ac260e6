"""A program: a MATLAB file comes in, its real arrays of numbers go out; scipy reads, and may crash on a damaged file."""

import io
import math
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

TOO_LARGE = 3
MOST_MEMORY = 1_500_000_000
DEEPEST = 5
NO_NUMBERS = ("char", "cell", "struct", "object", "function", "opaque", "sparse")


def main(most_numbers: int, most_arrays: int) -> int:
    """Write the arrays of the file at the standard input as `.npz`; TOO_LARGE where they are too many or too long."""
    from scipy.io import loadmat, whosmat

    file: Any = io.BytesIO(sys.stdin.buffer.read())  # as scipy documents; its stubs know paths only
    _limit_memory()
    try:
        sizes = [
            math.prod(int(n) for n in shape) for _, shape, kind in whosmat(file) if kind not in NO_NUMBERS
        ]
        if sum(sizes) > most_numbers:
            return TOO_LARGE
        names, arrays = [], []
        for name, value in loadmat(file).items():
            for path, array in _arrays(name, value, 0):
                names.append(path)
                arrays.append(array)
        if len(arrays) > most_arrays or sum(array.size for array in arrays) > most_numbers:
            return TOO_LARGE
    except MemoryError:
        return TOO_LARGE
    np.savez(sys.stdout.buffer, *arrays, names=np.array(names, dtype=np.str_))
    return 0


def _limit_memory() -> None:
    """Make the system refuse more memory than any file within the limits needs, where it can."""
    try:
        import resource
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))


def _arrays(path: str, value: Any, depth: int) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """Yield the real two-dimensional arrays of a value; fields as `data.acc`, members `data(2).acc`, cells `c{1}`."""
    if type(value) is not np.ndarray or depth > DEEPEST:  # objects and functions are kinds of arrays
        return
    members = value.ravel(order="F")
    if value.dtype.names:
        for i, member in enumerate(members):
            number = f"({i + 1})" if len(members) > 1 else ""
            for name in value.dtype.names:
                yield from _arrays(f"{path}{number}.{name}", member[name], depth + 1)
    elif value.dtype == object:
        for i, member in enumerate(members):
            yield from _arrays(f"{path}{{{i + 1}}}" if len(members) > 1 else path, member, depth + 1)
    elif value.dtype.kind in "biuf" and value.ndim == 2 and value.size:
        yield path, value


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
