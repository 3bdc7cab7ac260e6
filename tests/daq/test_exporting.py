"""Every format is read back by its own library: same numbers, names, units and facts."""

import csv
import io
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from daq.errors import OperatorError
from daq.exporting import FORMATS, Exported, encode, form_of
from daq.importing import ImportOptions, read_file
from daq.recording import Channel, Recording

COUNT = 300


def recording(rate: float = 256.0, lost: tuple[int, ...] = (7,)) -> Recording:
    random = np.random.default_rng(3)
    time = np.arange(COUNT) / rate
    motion = 0.004 * np.cos(2 * np.pi * 4.2 * time) * np.exp(-0.3 * time)
    valid = np.ones(COUNT, dtype=bool)
    valid[list(lost)] = False
    channels = (
        Channel("LVDT", "displacement", "m", sensor="LVDT 17", calibration_uncertainty=0.005),
        Channel("IEPE 1", "acceleration", "m/s^2"),
        Channel("IEPE 2", "acceleration", "m/s^2"),
        Channel("temp °C", "other", "1"),
    )
    samples = np.vstack([motion, -700 * motion, random.normal(size=COUNT), random.normal(20, 1, COUNT)])
    return Recording(rate, channels, samples, valid)


def exported(**more: float) -> Exported:
    return Exported(recording(**more), {"session": "s1", "operator": "Åse\nx", "lag_s": "0.0023"})  # type: ignore[arg-type]


NAMES = ("displacement", "acceleration", "acceleration_2", "temp_c")


def check(values: dict[str, object], source: Exported) -> None:
    for name, mine in zip(NAMES, source.samples, strict=True):
        np.testing.assert_array_equal(np.ravel(np.asarray(values[name], dtype=float)), mine, err_msg=name)


def test_csv_by_the_standard_library() -> None:
    source = exported()
    lines = encode(source, "csv").decode().splitlines()
    said = [line for line in lines if line.startswith("#")]
    assert "# operator: Åse x" in said, "a line break in a name must not begin a line of its own"
    rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    assert rows[0] == [
        "time [s]",
        "displacement [m]",
        "acceleration [m/s^2]",
        "acceleration_2 [m/s^2]",
        "temp_c [1]",
    ]
    columns = zip(*rows[1:], strict=True)
    values = {n: [float(v or "nan") for v in c] for n, c in zip(("time", *NAMES), columns, strict=True)}
    check(values, source)
    np.testing.assert_array_equal(values["time"], np.arange(COUNT) / 256.0)


def test_matlab_by_scipy() -> None:
    from scipy.io import loadmat

    source = exported()
    found = loadmat(io.BytesIO(encode(source, "mat")), squeeze_me=True, simplify_cells=True)
    check(found, source)
    assert found["rate"] == 256.0
    assert found["units"]["acceleration_2"] == "m/s^2"
    assert found["calibration"]["displacement"]["sensor"] == "LVDT 17"
    assert found["facts"]["lag_s"] == "0.0023"
    assert not found["valid"][7]


@pytest.mark.parametrize("rate", [256.0, 19.72733121225], ids=["even", "not in six digits"])
def test_universal_file_by_pyuff(tmp_path: Path, rate: float) -> None:
    import pyuff

    source = exported(rate=rate)
    (tmp_path / "x.uff").write_bytes(encode(source, "uff"))
    sets = pyuff.UFF(str(tmp_path / "x.uff")).read_sets()
    kept = np.arange(COUNT) != 7
    for one, mine in zip(sets, source.recording.samples, strict=True):
        np.testing.assert_allclose(one["data"], mine[kept], rtol=1e-11)
    assert [one["ordinate_spec_data_type"] for one in sets] == [8, 12, 12, 0]
    assert [one["ordinate_axis_units_lab"].strip() for one in sets] == ["m", "m/s^2", "m/s^2", "1"]
    assert sets[0]["id1"].strip() == "displacement"
    np.testing.assert_allclose(sets[0]["x"], (np.arange(COUNT) / rate)[kept], rtol=1e-9)


def test_hdf5_by_h5py() -> None:
    h5py = pytest.importorskip("h5py")
    source = exported()
    with h5py.File(io.BytesIO(encode(source, "hdf5"))) as file:
        check({name: file[name][:] for name in NAMES}, source)
        assert file["acceleration"].attrs["unit"] == "m/s^2"
        assert file["displacement"].attrs["calibration_uncertainty"] == "0.005"
        assert file.attrs["operator"] == "Åse\nx"
        assert file["displacement"].dims[0]["time"][1] == 1 / 256


def test_parquet_by_pyarrow() -> None:
    import pyarrow.parquet as pq

    source = exported()
    table = pq.read_table(io.BytesIO(encode(source, "parquet")))
    check({name: table[name].to_numpy() for name in NAMES}, source)
    assert table.schema.field("displacement").metadata[b"unit"] == b"m"
    assert table.schema.metadata[b"session"] == b"s1"
    assert table["valid"].to_pylist().count(False) == 1


def test_mcap_by_its_reader() -> None:
    reader_module = pytest.importorskip("mcap.reader")
    source = exported()
    reader = reader_module.make_reader(io.BytesIO(encode(source, "mcap")))
    messages = [(m.log_time, json.loads(m.data)) for _, _, m in reader.iter_messages(topics=["/samples"])]
    assert messages[256][0] == 1_000_000_000
    values = {n: [np.nan if m[n] is None else m[n] for _, m in messages] for n in NAMES}
    check(values, source)
    facts = {record.name: record.metadata for record in reader.iter_metadata()}
    assert facts["recording"]["lag_s"] == "0.0023"
    assert facts["displacement"]["unit"] == "m"


@pytest.mark.parametrize("form", ["csv", "mat", "uff"])
def test_what_is_exported_can_be_imported_again(form: str) -> None:
    whole = recording(lost=())
    source = Exported(Recording(whole.rate, whole.channels[:2], whole.samples[:2], whole.valid))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"x{FORMATS[form][0]}"
        path.write_bytes(encode(source, form))
        again = read_file(path, ImportOptions())
    assert again.rate == pytest.approx(256.0, rel=1e-9)
    for quantity in ("displacement", "acceleration"):
        mine, theirs = source.recording.channel(quantity), again.channel(quantity)
        assert mine is not None
        assert theirs is not None
        np.testing.assert_allclose(theirs, mine, rtol=1e-11)
    assert [c.unit for c in again.channels][:2] == ["m", "m/s^2"]


def test_the_ending_tells_the_format() -> None:
    assert {form_of(Path(f"x{ending}")) for ending, _ in FORMATS.values()} == set(FORMATS)
    assert form_of(Path("x.HDF5")) == "hdf5"
    assert form_of(Path("x.doc")) is None


def test_a_library_that_is_not_there_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(
        OperatorError, match=r"needs the package h5py.*pip install 'free-decay-station\[export\]'"
    ):
        encode(exported(), "hdf5")
