"""Universal files as pyuff writes them: one trace a data set, meaning by its codes."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from import_files import RATE, load, refusal, said, swing

T, U, V, A = swing(300)


def trace(values: np.ndarray, code: int, unit: str = "", **changes: Any) -> dict[str, Any]:
    """Return one data set 58; codes: 8 displacement, 11 velocity, 12 acceleration, 13 force."""
    fields = {
        "binary": 0, "func_type": 1, "rsp_node": 3, "rsp_dir": 3, "ref_node": 0, "ref_dir": 0, "data": values, "x": T,
        "id1": "bench", "ordinate_spec_data_type": code, "ordinate_axis_lab": "response",
        "ordinate_axis_units_lab": unit or "NONE", "abscissa_spec_data_type": 17, "abscissa_spacing": 1,
        "abscissa_inc": 1 / RATE, "abscissa_min": 0.0, "z_axis_value": 0.0, "rsp_ent_name": "NONE", "ref_ent_name": "NONE",
        "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0, "ord_data_type": 4,
    }  # fmt: skip
    return {**pyuff.prepare_58(), "type": 58, **fields, **changes}


def universal(tmp_path: Path, *traces: dict[str, Any]) -> bytes:
    path = tmp_path / "written.uff"
    path.unlink(missing_ok=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pyuff.UFF(str(path)).write_sets(
            list(traces), mode="add"
        )  # over a binary set pyuff loses the one before
    return path.read_bytes()


@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("spacing", [0, 1])
def test_several_traces_of_one_file_become_channels(tmp_path: Path, binary: int, spacing: int) -> None:
    changes = {"binary": binary, "abscissa_spacing": spacing}
    data = universal(tmp_path, trace(U, 8, **changes), trace(A, 12, "g", **changes))
    recording = load(tmp_path, data, "a.uff")
    assert [(c.quantity, c.unit) for c in recording.channels] == [
        ("displacement", "m"),
        ("acceleration", "m/s^2"),
    ]
    np.testing.assert_allclose(recording.samples[0], U, rtol=1e-10)
    np.testing.assert_allclose(recording.samples[1], A * 9.80665, rtol=1e-10)
    assert recording.rate == pytest.approx(RATE, rel=1e-5)  # the format keeps six digits of the interval
    assert "data set 1 'response 3:+Z' read as displacement in m" in said(recording)


def test_a_velocity_and_a_force_are_recognised_by_their_codes(tmp_path: Path) -> None:
    recording = load(tmp_path, universal(tmp_path, trace(V, 11, "mm/s"), trace(A, 13)), "a.unv")
    assert [(c.quantity, c.unit) for c in recording.channels] == [("velocity", "m/s"), ("force", "N")]


def test_of_several_like_traces_none_is_taken_unasked(tmp_path: Path) -> None:
    data = universal(tmp_path, trace(A, 12), trace(2 * A, 12, rsp_node=4))
    message = refusal(tmp_path, data, "a.uff")
    assert "2 data sets could be the acceleration" in message
    recording = load(tmp_path, data, "a.uff", columns={"acceleration": 2})
    np.testing.assert_allclose(recording.samples[0], 2 * A, rtol=1e-10)
    by_node = load(tmp_path, data, "a.uff", columns={"acceleration": "4:+Z"})
    np.testing.assert_array_equal(by_node.samples, recording.samples)


def test_spectra_are_left_out_and_reported(tmp_path: Path) -> None:
    spectrum = trace(A + 1j * A, 12, func_type=4)
    recording = load(tmp_path, universal(tmp_path, spectrum, trace(U, 8)), "a.uff")
    assert [c.quantity for c in recording.channels] == ["displacement"]
    assert "left out" in said(recording)
    assert "no time trace" in refusal(tmp_path, universal(tmp_path, spectrum), "a.uff")


def test_a_trace_of_unknown_kind_can_be_named(tmp_path: Path) -> None:
    data = universal(tmp_path, trace(U, 0, "mm"))
    recording = load(tmp_path, data, "a.uff", columns={"displacement": 1})
    np.testing.assert_allclose(recording.samples[0], U * 1e-3, rtol=1e-10)


@pytest.mark.parametrize("cut", [30, 100, 500, 1100, 3000])
def test_a_file_cut_short_gets_a_sentence(tmp_path: Path, cut: int) -> None:
    assert refusal(tmp_path, universal(tmp_path, trace(U, 8))[:cut], "a.uff")


def test_a_header_that_promises_more_samples_than_the_file_holds_is_refused(tmp_path: Path) -> None:
    data = universal(tmp_path, trace(U, 8)).replace(b"       300", b"2000000000", 1)
    assert "promises" in refusal(tmp_path, data, "a.uff")
