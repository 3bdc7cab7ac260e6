"""Whatever the bytes: a recording or one sentence; no traceback, no runaway memory."""

import io
import json
import os
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from import_files import swing, table
from scipy.io import savemat

from daq.importing import ImportOptions, ImportProblem, Recipe, read_file, read_recipe, read_runs
from daq.importing.recipe import ROLES, to_toml
from daq.recording import Recording

T, U, V, A = swing(60)
GOOD = table("time_s,displacement_m,acceleration_m_s2", T, U, A).encode()
EXAMPLES = int(os.environ.get("STATION_EXAMPLES", "10"))  # `python -m bench fuzz` goes on for minutes
FUZZ = settings(
    max_examples=EXAMPLES,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
CHOICES = st.sampled_from(
    [ImportOptions(), ImportOptions(resample=True), ImportOptions(columns={"displacement": 2}, rate=9.0)]
)


def assert_harmless(folder: Path, content: bytes, options: ImportOptions | None = None) -> Recording | None:
    """Import the bytes; anything but a recording or a sentence of one line fails the test."""
    path = folder / "fuzz.dat"
    path.write_bytes(content)
    tracemalloc.start()
    try:
        recording = read_file(path, options)
    except ImportProblem as refused:
        message = str(refused)
        assert message.startswith("fuzz.dat")
        assert "\n" not in message
        assert len(message) < 1500
        return None
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 400e6
    assert np.isfinite(recording.samples[:, recording.valid]).all()
    assert np.isfinite(recording.rate)
    assert recording.samples.size <= 50 * max(len(content), 1000)
    return recording


@FUZZ
@given(content=st.binary(max_size=3000), options=CHOICES)
def test_random_bytes_do_no_harm(tmp_path: Path, content: bytes, options: ImportOptions) -> None:
    assert_harmless(tmp_path, content, options)


CELLS = st.one_of(
    st.floats(width=64).map(repr),
    st.integers(-(10**400), 10**400).map(str),
    st.sampled_from(
        [
            "",
            "nan",
            "inf",
            "-inf",
            "1e999",
            "-1e308",
            "1e-320",
            "0",
            "1,5",
            "12:00:00",
            "x",
            '"',
            "''",
            "#",
            "1_0",
        ]
    ),
    st.text(max_size=5),
)


@FUZZ
@given(
    rows=st.lists(st.lists(CELLS, min_size=1, max_size=5), min_size=1, max_size=40),
    delimiter=st.sampled_from([",", ";", "\t", " "]),
    header=st.sampled_from(
        ["", "time_s,displacement_m", "t;x;v", "time (ms)\tposition (mm)", "x", "t,x,y,z"]
    ),
    options=CHOICES,
)
def test_tables_of_anything_do_no_harm(
    tmp_path: Path, rows: list[list[str]], delimiter: str, header: str, options: ImportOptions
) -> None:
    text = header + "\n" + "\n".join(delimiter.join(row) for row in rows)
    assert_harmless(tmp_path, text.encode("utf-8", errors="replace"), options)


@FUZZ
@given(
    numbers=st.lists(st.tuples(st.floats(width=64), st.floats(width=64)), min_size=8, max_size=60),
    sort=st.booleans(),
    options=CHOICES,
)
def test_tables_of_any_numbers_do_no_harm(
    tmp_path: Path, numbers: list[tuple[float, float]], sort: bool, options: ImportOptions
) -> None:
    rows = sorted(numbers) if sort else numbers
    assert_harmless(
        tmp_path, ("time_s,displacement_m\n" + "\n".join(f"{a!r},{b!r}" for a, b in rows)).encode(), options
    )


def mangled(data: bytes, places: list[tuple[int, int]], cut: int) -> bytes:
    content = bytearray(data)
    for place, value in places:
        content[place % len(content)] = value
    return bytes(content[: max(1, len(content) - cut % len(content))])


BYTES = st.lists(st.tuples(st.integers(0, 1 << 20), st.integers(0, 255)), max_size=12)


@FUZZ
@given(places=BYTES, cut=st.integers(0, 4000))
def test_a_mangled_table_does_no_harm(tmp_path: Path, places: list[tuple[int, int]], cut: int) -> None:
    assert_harmless(tmp_path, mangled(GOOD, places, cut))


def matlab_file(compressed: bool) -> bytes:
    stream = io.BytesIO()
    savemat(stream, {"t": T, "displacement": U, "s": {"a": A, "b": "text"}}, do_compression=compressed)
    return stream.getvalue()


@FUZZ
@given(places=BYTES, cut=st.one_of(st.just(0), st.integers(0, 4000)), compressed=st.booleans())
def test_a_mangled_matlab_file_does_no_harm(
    tmp_path: Path, places: list[tuple[int, int]], cut: int, compressed: bool
) -> None:
    assert_harmless(tmp_path, mangled(matlab_file(compressed), places, cut))


@FUZZ
@given(places=BYTES, cut=st.one_of(st.just(0), st.integers(0, 4000)), binary=st.integers(0, 1))
def test_a_mangled_universal_file_does_no_harm(
    tmp_path: Path, places: list[tuple[int, int]], cut: int, binary: int
) -> None:
    from test_importing_uff58 import trace, universal

    changes = {"x": T, "binary": binary}
    assert_harmless(
        tmp_path, mangled(universal(tmp_path, trace(U, 8, **changes), trace(A, 12, **changes)), places, cut)
    )


@pytest.mark.parametrize(
    "content",
    [
        ("a" + ",a" * 9_999 + "\n" + ("1" + ",1" * 9_999 + "\n") * 5).encode(),
        ("1" + ",1" * 99_999 + "\n").encode(),
        b"1\n" * 100_000,
        b"1,2\n",
        b"time_s,x_m\n1,2\n",
        b'"' * 300_000,
        b"time_s,x_m\n" + b'"' * 200_000 + b"\n" + b"1,2\n" * 20,
        b"9" * 400_000,
        b"time_s,x_m\n" + b"\n".join(b"%d,1e308" % i for i in range(50)),
        b"    -1\n    58\n" * 5000,
        b"    -1\n" * 5000,
        b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\x00\x01IM" + b"\xff" * 200,
        b";" * 100_000,
        b" ,;\t\n" * 5000,
        b"-" * 100_000,
        b"1e5" * 50_000,
        ("\u2028" * 5000).encode(),
    ],
)
def test_odd_shapes_do_no_harm(tmp_path: Path, content: bytes) -> None:
    assert assert_harmless(tmp_path, content) is None


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(10**400), 10**400) | st.floats() | st.text(max_size=6),
    lambda inner: st.lists(inner, max_size=12) | st.dictionaries(st.text(max_size=6), inner, max_size=6),
    max_leaves=60,
)


@FUZZ
@given(document=VALUES, key=st.sampled_from(["data", "t", "dt", "fs", "units", "x units"]))
def test_any_json_is_read_or_refused_in_a_sentence(tmp_path: Path, document: object, key: str) -> None:
    rows = [[0.01 * i, 0.02 * (-1) ** i] for i in range(20)]
    assert_harmless(tmp_path, json.dumps(document).encode())
    assert_harmless(tmp_path, json.dumps({"columns": ["t", "x"], "signal": rows, key: document}).encode())


NAMES = st.sampled_from(
    [
        "t",
        "t1",
        "t2",
        "x",
        "x1",
        "x2",
        "Run 1: t",
        "Run 2: x",
        "ax",
        "ay",
        "az",
        "dt",
        "",
        "run",
        "theta",
        "y",
    ]
)


@FUZZ
@given(data=st.data())
def test_any_names_over_any_columns_do_no_harm(tmp_path: Path, data: st.DataObject) -> None:
    width = data.draw(st.integers(1, 7))
    names = [data.draw(NAMES) for _ in range(width)]
    kinds = [data.draw(st.sampled_from(["time", "motion", "still", "count", "holes"])) for _ in range(width)]
    made = {"time": T, "motion": U, "still": np.full(60, 9.8), "count": np.repeat([1.0, 2.0], 30), "holes": U}
    rows = [
        ";".join("" if kind == "holes" and i > 40 else f"{made[kind][i]:.9g}" for kind in kinds)
        for i in range(60)
    ]
    assert_harmless(tmp_path, "\n".join([";".join(names), *rows]).encode())


FIELDS = st.fixed_dictionaries(
    {"column": st.integers(-1, 5), "role": st.sampled_from([*ROLES, "speed"])},
    optional={
        "name": st.sampled_from(["", "x", "time_s", "displacement_m"]),
        "unit": st.sampled_from(["", "mm", "deg", "ms", "1e-300 m", "9e29 m", "no unit"]),
        "zero": st.one_of(st.floats(), st.sampled_from(["median", "mean"])),
        "wraps": st.floats(),
        "sign": st.integers(-2, 2),
        "run": st.sampled_from(["", "1", "2"]),
    },
)
RECIPES = st.fixed_dictionaries(
    {"fields": st.lists(FIELDS, max_size=5)},
    optional={
        "rate": st.floats(),
        "resample": st.booleans(),
        "restarts": st.booleans(),
        "runs": st.lists(st.sampled_from(["1", "2", "9"]), max_size=2),
        "parts": st.lists(
            st.dictionaries(st.sampled_from(["from", "to"]), st.floats(-1.0, 9.0), max_size=2), max_size=3
        ),
        "encoding": st.sampled_from(["utf-8", "utf-16", "no such", "punycode"]),
        "dialect": st.fixed_dictionaries(
            {},
            optional={
                "header": st.booleans(),
                "commentRows": st.lists(st.integers(0, 99), max_size=3),
                "delimiter": st.sampled_from([",", "tab", " ", "0"]),
                "decimalChar": st.sampled_from([".", ",", "-"]),
            },
        ),
    },
)


@FUZZ
@given(said=RECIPES)
def test_any_recipe_reads_or_is_refused_in_a_sentence(tmp_path: Path, said: dict[str, object]) -> None:
    file, written = tmp_path / "good.csv", tmp_path / "fuzz.toml"
    file.write_bytes(GOOD)
    written.write_text("".join(f"{key} = {_toml(value)}\n" for key, value in said.items()), encoding="utf-8")
    try:
        recipe = read_recipe(written)
        assert read_recipe_again(tmp_path, recipe) == recipe
        recordings = read_runs(file, recipe=recipe)
    except ImportProblem as refused:
        message = str(refused)
        recordings = ()
    else:
        message = "good.csv"
    assert message.startswith(("fuzz.toml", "good.csv"))
    assert "\n" not in message
    assert all(np.isfinite(one.samples[:, one.valid]).all() for one in recordings)


def _toml(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return str(value) if isinstance(value, float) else json.dumps(value)


def read_recipe_again(folder: Path, recipe: Recipe) -> Recipe:
    """Write a recipe as an import does, and read it."""
    (folder / "again.toml").write_text(to_toml(recipe), encoding="utf-8")
    return read_recipe(folder / "again.toml")


@FUZZ
@given(content=st.binary(max_size=300))
def test_any_bytes_are_no_recipe_or_one(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "fuzz.toml").write_bytes(content)
    message = ""
    try:
        read_recipe(tmp_path / "fuzz.toml")
    except ImportProblem as refused:
        message = str(refused)
    assert "\n" not in message


@pytest.mark.parametrize(
    ("rows", "says"), [(1, "has 1 sample;"), (2, "has 2 samples;"), (7, "has 7 samples;")]
)
def test_a_few_rows_are_no_recording(tmp_path: Path, rows: int, says: str) -> None:
    path = tmp_path / "few.csv"
    path.write_bytes(table("time_s,displacement_m", T[:rows], U[:rows]).encode())
    with pytest.raises(ImportProblem, match=says):
        read_file(path)


def test_rows_that_repeat_do_not_count_as_samples(tmp_path: Path) -> None:
    path = tmp_path / "few.csv"
    path.write_bytes(table("time_s,displacement_m", np.r_[T[:7], T[6]], np.r_[U[:7], U[6]]).encode())
    with pytest.raises(ImportProblem, match="has 7 samples;"):
        read_file(path)
