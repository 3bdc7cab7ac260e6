"""MATLAB files of version 5 (and 4): vectors by name, fields of structures, a rate or time among them."""

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from daq.importing import mat_reader
from daq.importing.errors import MAX_NUMBERS, problem, require_table
from daq.importing.numbers import rate_of
from daq.importing.recipe import Recipe
from daq.importing.table import SourceColumn, Table, common_length
from daq.plain_text import one_line
from daq.recording import Array

Numbers = np.ndarray[Any, np.dtype[Any]]
MAX_ARRAYS = 20_000
LONGEST_S = 120.0
HDF5 = b"\x89HDF\r\n\x1a\n"


def is_matlab(data: bytes) -> bool:
    """Check whether these bytes begin a MATLAB file of any version."""
    if data[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        return True
    return data.startswith((b"MATLAB", HDF5)) or data[512:520] == HDF5 or _is_version_4(data)


def _is_version_4(data: bytes) -> bool:
    """Recognise a version 4 header: type, rows, columns, imaginary flag, length of a printable name."""
    if len(data) < 24:
        return False
    for order in ("<i4", ">i4"):
        kind, rows, columns, imaginary, length = np.frombuffer(data[:20], order).tolist()
        name = data[20 : 20 + length] if 1 < length < 64 else b""
        plausible = (
            kind % 10 == 0 and 0 <= kind <= 4050 and imaginary in (0, 1) and 0 < rows * columns <= len(data)
        )
        if plausible and rows > 0 and name.endswith(b"\0") and name[:-1].decode("latin-1").isidentifier():
            return True
    return False


def read_matlab(path: Path, data: bytes, recipe: Recipe) -> Table:
    """Return the vectors of a MATLAB file as columns. Raises ImportProblem; no code of the file is run."""
    if HDF5 in data[:520]:
        raise problem(
            path, "is a MATLAB file of version 7.3 (HDF5), which is not read here",
            "save it again in MATLAB with save(..., '-v7') or export it as CSV",
        )  # fmt: skip
    vectors: list[tuple[str, Array]] = []
    scalars: dict[str, float | str] = {}
    for name, value in read_arrays(path, data):
        if value.size == 1:
            scalars[name] = float(value.ravel()[0])
        else:
            vectors.extend(_as_vectors(name, value))
    if not vectors:
        raise problem(path, "holds no vector of numbers", "save the time and the channels as vectors")
    length = common_length(path, recipe, [((name,), len(values)) for name, values in vectors])
    kept = [(name, values) for name, values in vectors if len(values) == length]
    require_table(path, length, len(kept))
    columns = tuple(
        SourceColumn(i + 1, name, values, noun="variable") for i, (name, values) in enumerate(kept)
    )
    notes = [f"MATLAB file: {len(columns)} vectors of {length} samples"]
    if len(kept) < len(vectors):
        others = [name for name, values in vectors if len(values) != length]
        notes.append(f"variables of other lengths were left out: {', '.join(others[:6])}")
    rate, source = rate_of(scalars)
    return Table(path, columns, None, rate, f"the variable {source}", tuple(notes), format="matlab")


def read_arrays(path: Path, data: bytes) -> list[tuple[str, Numbers]]:
    """Return the real arrays of numbers in a file as (name, array), read in a process of its own.

    Files come from anywhere, and scipy's compiled reader crashes on some damaged ones. Raises ImportProblem.
    """
    limits = map(str, (MAX_NUMBERS, MAX_ARRAYS))
    reader = [sys.executable, "-P", mat_reader.__file__, *limits]  # -P: no module of the working folder
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    try:
        done = subprocess.run(reader, input=data, capture_output=True, timeout=LONGEST_S, env=environment)
    except subprocess.TimeoutExpired:
        raise problem(
            path, f"was not read within {LONGEST_S:g} s", "save it again with save(..., '-v7')"
        ) from None
    if done.returncode == mat_reader.TOO_LARGE:
        raise problem(
            path, f"holds more than {MAX_NUMBERS / 1e6:.0f} million numbers or {MAX_ARRAYS} arrays, "
            "or asks for too much memory",
            "save only the channels of one recording",
        )  # fmt: skip
    if done.returncode:
        last = done.stderr.decode(errors="replace").strip().rpartition("\n")[2]
        said = one_line(last.partition(": ")[2])[:120]
        raise problem(
            path,
            f"is a damaged MATLAB file ({said or 'its reader crashed'})",
            "save it again with save(..., '-v7')",
        )
    with np.load(io.BytesIO(done.stdout)) as found:
        return [(name, found[f"arr_{i}"]) for i, name in enumerate(found["names"].tolist())]


def _as_vectors(name: str, value: Numbers) -> list[tuple[str, Array]]:
    """Return a matrix as its columns (its rows when it is wide), a vector as itself."""
    matrix = np.asarray(value, dtype=np.float64)
    if matrix.shape[0] < matrix.shape[1]:
        matrix = matrix.T
    if matrix.shape[1] == 1:
        return [(name, matrix[:, 0])]
    return [(f"{name}(:,{i + 1})", matrix[:, i]) for i in range(min(matrix.shape[1], 200))]
