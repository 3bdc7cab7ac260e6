"""MATLAB files of version 5 (and 4): vectors by name, fields of structures, a rate or time among them."""

import math
import warnings
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing.errors import ImportProblem, problem
from daq.importing.options import ImportOptions
from daq.importing.table import SourceColumn, Table
from daq.recording import Array

MAX_NUMBERS = 100_000_000
HDF5 = b"\x89HDF\r\n\x1a\n"
RATES = (
    "fs",
    "fsamp",
    "samplerate",
    "sample_rate",
    "samplingrate",
    "sampling_rate",
    "rate",
    "sr",
    "fsample",
    "freqsampling",
)
PERIODS = ("ts", "dt", "deltat", "delta_t", "tsample", "sampletime", "sample_time")
MAX_DEPTH = 4


def is_matlab(data: bytes) -> bool:
    """Tell whether these bytes begin a MATLAB file of any version above 4."""
    return data.startswith((b"MATLAB", HDF5)) or data[512:520] == HDF5 or _is_version_4(data)


def _is_version_4(data: bytes) -> bool:
    """Tell a version 4 header: type, rows, columns, imaginary flag, length of a printable name."""
    if len(data) < 24:
        return False
    for order in ("<i4", ">i4"):
        kind, rows, columns, imaginary, name = np.frombuffer(data[:20], order).tolist()
        if (
            kind % 10 == 0
            and 0 <= kind <= 4050
            and rows > 0
            and columns > 0
            and imaginary in (0, 1)
            and 1 < name < 64
        ):
            text = data[20 : 20 + name]
            if (
                text.endswith(b"\0")
                and text[:-1].decode("latin-1").isidentifier()
                and rows * columns <= len(data)
            ):
                return True
    return False


def read_matlab(path: Path, data: bytes, options: ImportOptions) -> Table:
    """Return the vectors of a MATLAB file as columns. Raises ImportProblem; no code of the file is run."""
    if HDF5 in data[:520]:
        raise problem(
            path, "is a MATLAB file of version 7.3 (HDF5), which is not read here",
            "save it again in MATLAB with save(..., '-v7') or export it as CSV",
        )  # fmt: skip
    contents = _load(path, data)
    vectors: list[tuple[str, Array]] = []
    scalars: dict[str, float] = {}
    for name, value in _numeric(contents, "", 0):
        if value.size == 1:
            scalars[name] = float(value.ravel()[0])
        else:
            vectors.extend(_as_vectors(name, value))
    if not vectors:
        raise problem(path, "holds no vector of numbers", "save the time and the channels as vectors")
    length = _length(path, vectors, options)
    kept = [(name, values) for name, values in vectors if len(values) == length]
    columns = tuple(
        SourceColumn(i + 1, name, values, noun="variable") for i, (name, values) in enumerate(kept)
    )
    notes = [f"MATLAB file: {len(columns)} vectors of {length} samples"]
    if len(kept) < len(vectors):
        others = [name for name, values in vectors if len(values) != length]
        notes.append(f"variables of other lengths were left out: {', '.join(others[:6])}")
    rate, source = _rate(scalars)
    return Table(path, columns, None, rate, source, tuple(notes))


def _load(path: Path, data: bytes) -> dict[str, Any]:
    from scipy.io import loadmat, whosmat

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if _unpacked(data) > 16 * MAX_NUMBERS:
                raise _too_large(path)
            shapes = [shape for _, shape, _ in whosmat(str(path), appendmat=False)]
            if sum(math.prod(map(int, shape)) for shape in shapes) > MAX_NUMBERS:
                raise _too_large(path)
            return dict(loadmat(str(path), appendmat=False))
    except ImportProblem:
        raise
    except MemoryError:
        raise problem(
            path, "asks for more memory than there is", "save only the channels of one recording"
        ) from None
    except Exception as error:
        said = " ".join(str(error).split())[:80] or type(error).__name__
        raise problem(
            path, f"is a damaged or unknown MATLAB file ({said})", "save it again with save(..., '-v7')"
        ) from None


def _too_large(path: Path) -> ImportProblem:
    return problem(path, f"holds more than {MAX_NUMBERS} numbers", "save only the channels of one recording")


def _unpacked(data: bytes) -> int:
    """Return about how many bytes the compressed elements of a version 5 file unpack to, up to the limit."""
    total, at, limit = 0, 128, 16 * MAX_NUMBERS
    order = "<" if data[126:128] == b"IM" else ">"
    while at + 8 <= len(data) and total <= limit:
        kind, size = (int(v) for v in np.frombuffer(data[at : at + 8], f"{order}u4"))
        if kind == 15:
            unpacker = zlib.decompressobj()
            chunk = data[at + 8 : at + 8 + size]
            try:
                while chunk and not unpacker.eof and total <= limit:
                    total += len(unpacker.decompress(chunk, 1 << 24))
                    chunk = unpacker.unconsumed_tail
            except zlib.error:
                return total
        at += 8 + size
    return total


def _numeric(value: Any, name: str, depth: int) -> Iterator[tuple[str, np.ndarray[Any, Any]]]:
    """Yield every real array of numbers by its path, such as `data.acc`, from structures and single cells."""
    if isinstance(value, dict):
        for key, item in value.items():
            if not str(key).startswith("__"):
                yield from _numeric(item, str(key), depth)
        return
    if not isinstance(value, np.ndarray) or depth > MAX_DEPTH or value.size == 0:
        return
    if value.dtype.names:
        for field in value.dtype.names[:200]:
            for i, item in enumerate(value.ravel()[:20]):
                suffix = f"({i + 1})" if value.size > 1 else ""
                yield from _numeric(item[field], f"{name}{suffix}.{field}", depth + 1)
    elif value.dtype == object:
        for i, item in enumerate(value.ravel()[:200]):
            yield from _numeric(item, f"{name}{{{i + 1}}}" if value.size > 1 else name, depth + 1)
    elif value.dtype.kind in "fiu" and value.ndim == 2:
        yield name, value


def _as_vectors(name: str, value: np.ndarray[Any, Any]) -> list[tuple[str, Array]]:
    """Return a matrix as its columns (its rows when it is wide), a vector as itself."""
    matrix = np.asarray(value, dtype=np.float64)
    if matrix.shape[0] < matrix.shape[1]:
        matrix = matrix.T
    if matrix.shape[1] == 1:
        return [(name, matrix[:, 0])]
    return [(f"{name}(:,{i + 1})", matrix[:, i]) for i in range(min(matrix.shape[1], 200))]


def _length(path: Path, vectors: list[tuple[str, Array]], options: ImportOptions) -> int:
    """Return the length of the vectors that the options name, else the length that most numbers have."""
    wanted = {str(w).casefold() for w in options.columns.values()}
    named = {len(values) for name, values in vectors if name.casefold() in wanted}
    if len(named) > 1:
        raise problem(
            path,
            f"the variables asked for have different lengths ({sorted(named)})",
            "name variables of one length",
        )
    if named:
        return named.pop()
    lengths = [len(values) for _, values in vectors]
    return max(set(lengths), key=lambda n: (n >= 8, n * lengths.count(n)))


def _rate(scalars: dict[str, float]) -> tuple[float | None, str]:
    for name, value in scalars.items():
        key = name.rsplit(".", 1)[-1].lower()
        if key in RATES and 0.0 < value < 1e9:
            return value, f"the variable '{name}'"
        if key in PERIODS and 0.0 < value < 1e6:
            return 1.0 / value, f"the variable '{name}' (a sampling interval of {value:g} s)"
    return None, ""
