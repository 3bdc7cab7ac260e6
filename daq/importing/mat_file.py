"""The bytes of a MATLAB file of version 5 or 4: its real arrays of numbers, by name.

Layout after MathWorks, "MAT-File Format" (versions 4 and 5). It is read here, not by a general reader, because
files come from anywhere: compiled readers have been seen to crash on damaged ones, and this one only ever
looks at bytes that are there. Text, sparse arrays, functions and objects of classes are passed over.
"""

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from daq.importing.limits import LONGEST_NAME, MAX_BYTES, MAX_NUMBERS

Numbers = np.ndarray[Any, np.dtype[Any]]
MAX_ELEMENTS = 100_000
HEAD_BYTES = 1024
MAX_DIMENSIONS = 32
MAX_DEPTH = 5
MAX_FIELDS = 5000
MATRIX, COMPRESSED = 14, 15
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
CELL, STRUCTURE = 1, 2
NUMERIC = range(6, 16)
COMPLEX = 0x0800
VERSION_4_TYPES = ("f8", "f4", "i4", "i2", "u2", "u1")


class DamagedFileError(ValueError):
    """The bytes do not keep to the format; the message says how."""


class TooLargeError(ValueError):
    """The file unpacks to more than MAX_BYTES, or holds more than MAX_NUMBERS or MAX_ELEMENTS."""


@dataclass
class _File:
    """The order of bytes in a file, as numpy writes it, and how many elements of it were looked at."""

    order: str
    elements: int = 0

    def count(self) -> None:
        """Count one more element; TooLargeError when they are too many."""
        self.elements += 1
        if self.elements > MAX_ELEMENTS:
            raise TooLargeError


@dataclass(frozen=True)
class _Element:
    kind: int
    data: memoryview


def read_version_5(data: bytes) -> list[tuple[str, Numbers]]:
    """Return the real two-dimensional arrays of a version 5 file as (name, array); fields as `data.acc`.

    Raises DamagedFileError, and TooLargeError before more is unpacked than MAX_BYTES and MAX_NUMBERS allow.
    """
    if len(data) < 136 or data[126:128] not in (b"IM", b"MI"):
        raise DamagedFileError("its header is cut short")
    file = _File("<" if data[126:128] == b"IM" else ">")
    found: list[tuple[str, Numbers]] = []
    room, numbers = MAX_BYTES, 0
    for element in _elements(memoryview(data)[128:], file):
        if element.kind == COMPRESSED:
            unpacked = _unpack(element.data, room, MAX_NUMBERS - numbers, file)
            room -= len(unpacked)
            inner = next(_elements(memoryview(unpacked), file), None)
        else:
            inner = element
        if inner is not None and inner.kind == MATRIX:
            for name, array in _matrix(inner.data, file, "", 0):
                found.append((name, array))
                numbers += array.size
                if numbers > MAX_NUMBERS:
                    raise TooLargeError
    return found


def read_version_4(data: bytes) -> list[tuple[str, Numbers]]:
    """Return the real arrays of a version 4 file as (name, array). Raises as `read_version_5`."""
    found: list[tuple[str, Numbers]] = []
    file, at, numbers = _File("<"), 0, 0
    while at + 20 <= len(data):
        file.count()
        order = ">" if int.from_bytes(data[at : at + 4], "little") > 4052 else "<"
        kind, rows, columns, imaginary, length = np.frombuffer(data[at : at + 20], f"{order}i4").tolist()
        precision, matter = kind // 10 % 10, kind % 10
        if not (0 <= kind <= 4052 and precision < 6 and rows >= 0 and columns >= 0 and 0 < length < 1024):
            raise DamagedFileError(f"no variable begins at byte {at}")
        dtype = np.dtype(order + VERSION_4_TYPES[precision])
        start = at + 20 + length
        size = rows * columns * dtype.itemsize
        at = start + size * (2 if imaginary else 1)
        if at > len(data):
            raise DamagedFileError("it is cut short")
        name = data[start - length : start].split(b"\0")[0].decode("latin-1")
        numbers += rows * columns
        if size > MAX_BYTES or numbers > MAX_NUMBERS:
            raise TooLargeError
        if matter == 0 and not imaginary and size:
            found.append((name, _shaped(np.frombuffer(data[start : start + size], dtype), (rows, columns))))
    return found


def _unpack(packed: memoryview, room: int, numbers: int, file: _File) -> bytes:
    """Return an unpacked variable; TooLargeError by its head where it promises more bytes or numbers than allowed."""
    unpacker = zlib.decompressobj()
    try:
        head = unpacker.decompress(packed, HEAD_BYTES)
        if len(head) < HEAD_BYTES:
            return head
        size = int(np.frombuffer(head[4:8], f"{file.order}u4")[0]) + 8
        if size > room or _promised(head, file) > numbers:
            raise TooLargeError
        return head + unpacker.decompress(unpacker.unconsumed_tail, max(size - len(head), 1))
    except zlib.error as error:
        raise DamagedFileError(f"a compressed variable cannot be unpacked ({error})") from None


def _promised(head: bytes, file: _File) -> int:
    """Count the numbers that an array with these first bytes promises; 0 where it is no array of numbers."""
    flags, shape = np.frombuffer(head[16:20], f"{file.order}u4")[0] & 0xFF, head[24:]
    if flags not in NUMERIC:
        return 0
    kind, size = np.frombuffer(shape[:8], f"{file.order}u4").tolist()
    if kind != 5 or not 8 <= size <= 256:
        return 0
    return math.prod(np.frombuffer(shape[8 : 8 + size // 4 * 4], f"{file.order}i4").tolist())


def _elements(data: memoryview, file: _File) -> Iterator[_Element]:
    """Yield the elements that lie one after another in `data`."""
    at = 0
    while at + 8 <= len(data):
        file.count()
        first, size = np.frombuffer(data[at : at + 8], f"{file.order}u4").tolist()
        if first >> 16:  # a small element: type and size in four bytes, its data in the next four
            kind, size, start, at = first & 0xFFFF, first >> 16, at + 4, at + 8
            if size > 4:
                raise DamagedFileError("a small element is too long")
        else:
            kind, start = first, at + 8
            padding = 0 if kind == COMPRESSED else -size % 8
            at = start + size + padding
        if start + size > len(data):
            raise DamagedFileError("it is cut short, or the length of a variable is wrong")
        yield _Element(kind, data[start : start + size])


def _matrix(data: memoryview, file: _File, path: str, depth: int) -> Iterator[tuple[str, Numbers]]:
    """Yield the numbers of one array, or of the fields of a structure or the cells of a cell array."""
    parts = _elements(data, file)
    if len(data) == 0 or depth > MAX_DEPTH:
        return
    flags = _integers(next(parts, None), file)
    shape = tuple(_integers(next(parts, None), file))
    name = bytes(_need(next(parts, None)).data[:LONGEST_NAME]).decode("latin-1")
    if not flags or any(size < 0 for size in shape):
        raise DamagedFileError("the header of an array is damaged")
    path = path or name
    kind = flags[0] & 0xFF
    if kind in NUMERIC:
        if not flags[0] & COMPLEX and len(shape) == 2 and shape[0] * shape[1] > 0:
            yield path, _shaped(_numbers(_need(next(parts, None)), file), shape)
    elif kind == STRUCTURE:
        yield from _structure(parts, file, path, depth)
    elif kind == CELL:
        cells = [part.data for part in parts if part.kind == MATRIX][:MAX_FIELDS]
        for i, cell in enumerate(cells):
            yield from _matrix(cell, file, path if len(cells) == 1 else f"{path}{{{i + 1}}}", depth + 1)


def _structure(
    parts: Iterator[_Element], file: _File, path: str, depth: int
) -> Iterator[tuple[str, Numbers]]:
    width = _integers(next(parts, None), file)
    packed = bytes(_need(next(parts, None)).data)
    if not width or not 0 < width[0] <= 1024 or len(packed) > width[0] * MAX_FIELDS:
        raise DamagedFileError("the field names of a structure are damaged")
    names = [
        packed[i : i + width[0]].split(b"\0")[0].decode("latin-1") for i in range(0, len(packed), width[0])
    ]
    if not names:
        return
    values = [part.data for part in parts if part.kind == MATRIX][:MAX_FIELDS]
    several = len(values) > len(names)
    for i, value in enumerate(values):
        number = f"({i // len(names) + 1})" if several else ""
        yield from _matrix(value, file, f"{path}{number}.{names[i % len(names)]}", depth + 1)


def _need(element: _Element | None) -> _Element:
    if element is None:
        raise DamagedFileError("an array is cut short")
    return element


def _integers(element: _Element | None, file: _File) -> list[int]:
    if _need(element).kind not in (5, 6):
        raise DamagedFileError("the header of an array is damaged")
    return [int(value) for value in _numbers(_need(element), file)[:MAX_DIMENSIONS]]


def _numbers(element: _Element, file: _File) -> Numbers:
    name = TYPES.get(element.kind)
    if name is None:
        raise DamagedFileError(f"it holds numbers of an unknown type ({element.kind})")
    dtype = np.dtype(file.order + name)
    return np.frombuffer(element.data[: len(element.data) // dtype.itemsize * dtype.itemsize], dtype)


def _shaped(numbers: Numbers, shape: tuple[int, ...]) -> Numbers:
    if numbers.size != shape[0] * shape[1]:
        raise DamagedFileError(f"an array holds {numbers.size} numbers and promises {shape[0]} x {shape[1]}")
    return numbers.reshape(shape, order="F")
