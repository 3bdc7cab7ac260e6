"""MATLAB files: vectors, structures, rates by name; what is not read gets a sentence."""

import io
import struct
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from import_files import load, refusal, said, swing
from scipy.io import savemat

from daq.importing.matlab import read_arrays

T, U, V, A = swing(300)


@pytest.fixture(autouse=True)
def read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Start one process for the same bytes: `load` reads a file three times."""
    monkeypatch.setattr("daq.importing.matlab.read_arrays", cache(read_arrays))


def mat(version: str = "5", compressed: bool = False, **variables: object) -> bytes:
    stream = io.BytesIO()
    savemat(stream, variables, format=version, do_compression=compressed)
    return stream.getvalue()


@pytest.mark.parametrize(("version", "compressed"), [("5", False), ("5", True), ("4", False)])
def test_vectors_with_clear_names_need_no_options(tmp_path: Path, version: str, compressed: bool) -> None:
    recording = load(tmp_path, mat(version, compressed, t=T, displacement=U, acceleration=A), "a.mat")
    assert [c.quantity for c in recording.channels] == ["displacement", "acceleration"]
    np.testing.assert_allclose(recording.samples, [U, A], rtol=1e-15)
    assert recording.rate == pytest.approx(100.0)


@pytest.mark.parametrize(("name", "value"), [("fs", 250.0), ("Ts", 0.004), ("dt", 0.004), ("Fs", 250.0)])
def test_a_rate_is_found_by_its_variables_name(tmp_path: Path, name: str, value: float) -> None:
    recording = load(tmp_path, mat(disp_mm=U * 1e3, **{name: value}), "a.mat")
    assert recording.rate == pytest.approx(250.0)
    assert name in said(recording)
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-12)


def test_options_name_variables_and_units(tmp_path: Path) -> None:
    data = mat(V1=A, V2=U, Ovld=np.array([[0.0]]))
    assert "V1" in refusal(tmp_path, data, "a.mat")
    recording = load(
        tmp_path, data, "a.mat", columns={"displacement": "V2", "force": "V1"},
        units={"displacement": "V", "force": "V"}, rate=610.35,
    )  # fmt: skip
    assert [(c.quantity, c.unit) for c in recording.channels] == [("displacement", "V"), ("force", "V")]
    np.testing.assert_array_equal(recording.samples, [U, A])


def test_fields_of_structures_and_columns_of_matrices_are_vectors(tmp_path: Path) -> None:
    inner = {"time": T, "acc": A, "note": "a word"}
    recording = load(tmp_path, mat(data={"run": inner}), "a.mat")
    np.testing.assert_array_equal(recording.samples, [A])
    matrix = mat(y=np.column_stack([T, U]))
    recording = load(tmp_path, matrix, "a.mat", columns={"time": "y(:,1)", "displacement": 2})
    np.testing.assert_array_equal(recording.samples, [U])


def test_vectors_of_another_length_are_left_out_and_reported(tmp_path: Path) -> None:
    recording = load(
        tmp_path, mat(t=T, x_disp=U, calibration=np.arange(12.0)), "a.mat", columns={"displacement": "x_disp"}
    )
    assert recording.samples.shape == (1, 300)
    assert "calibration" in said(recording)


def test_whole_numbers_of_a_converter_are_read(tmp_path: Path) -> None:
    counts = np.round(U / 1e-5).astype(np.int16)
    recording = load(
        tmp_path,
        mat(ch1=counts, fs=100.0),
        "a.mat",
        columns={"displacement": "ch1"},
        units={"displacement": "1e-5 m"},
    )
    np.testing.assert_allclose(recording.samples[0], U, atol=0.51e-5)


def test_version_seven_three_gets_a_sentence(tmp_path: Path) -> None:
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b" ") + b"\x89HDF\r\n\x1a\n" + bytes(100)
    assert "-v7" in refusal(tmp_path, head, "a.mat")
    assert "-v7" in refusal(tmp_path, b"\x89HDF\r\n\x1a\n" + bytes(100), "a.mat")


@pytest.mark.parametrize("cut", [1, 127, 129, 140, 400, 2000])
def test_a_file_cut_short_gets_a_sentence(tmp_path: Path, cut: int) -> None:
    assert refusal(tmp_path, mat(t=T, displacement=U)[:cut], "a.mat")


def test_a_file_without_numbers_gets_a_sentence(tmp_path: Path) -> None:
    assert "no vector" in refusal(tmp_path, mat(name="text", one=1.0), "a.mat")


@pytest.mark.parametrize("compressed", [False, True])
def test_bytes_that_become_more_numbers_than_allowed_are_refused_before_they_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compressed: bool
) -> None:
    """One byte a number in the file, eight in memory."""
    monkeypatch.setattr("daq.importing.matlab.MAX_NUMBERS", 30_000)
    whole = mat(compressed=compressed, x=np.zeros(20_000, "i1"), y=np.zeros(9_000, "i1"))
    assert sum(values.size for _, values in read_arrays(tmp_path, whole)) == 29_000
    more = mat(compressed=compressed, x=np.zeros(20_000, "i1"), y=np.zeros(11_000, "i1"))
    assert "million numbers" in refusal(tmp_path, more, "a.mat")


@pytest.mark.parametrize("compressed", [False, True])
def test_whatever_holds_real_numbers_is_found(compressed: bool) -> None:
    """Every class of numbers, small elements, nested structures and cells."""
    variables: dict[str, object] = {
        name: (np.arange(6) - (0 if name.startswith("u") else 2)).astype(name).reshape(2, 3)
        for name in ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")
    }
    variables |= {"one": 3.5, "s": {"a": U, "b": {"c": np.eye(3), "word": "text"}}, "z": U + 1j}
    cells = np.empty((1, 2), dtype=object)
    cells[0, 0], cells[0, 1] = T, "text"
    data = mat(compressed=compressed, **variables, c=cells)
    found = dict(read_arrays(Path("a.mat"), data))
    assert set(found) == {*(n for n in variables if n not in ("s", "z")), "s.a", "s.b.c", "c{1}"}
    for name in set(found) & set(variables):
        np.testing.assert_array_equal(found[name], np.atleast_2d(variables[name]))
    np.testing.assert_array_equal(found["s.b.c"], np.eye(3))
    np.testing.assert_array_equal(found["s.a"].ravel(), U)
    np.testing.assert_array_equal(found["c{1}"].ravel(), T)


def test_a_file_of_the_other_byte_order_is_read() -> None:
    numbers = struct.pack(">II8d", 9, 64, *range(8))
    body = (
        struct.pack(">IIII", 6, 8, 6, 0)
        + struct.pack(">IIii", 5, 8, 8, 1)
        + struct.pack(">HH4s", 1, 1, b"x\0\0\0")
    )
    data = (
        b"MATLAB 5.0 MAT-file".ljust(124)
        + struct.pack(">H", 0x0100)
        + b"MI"
        + struct.pack(">II", 14, len(body + numbers))
        + body
        + numbers
    )
    ((name, array),) = read_arrays(Path("a.mat"), data)
    assert name == "x"
    np.testing.assert_array_equal(array.ravel(), np.arange(8.0))
