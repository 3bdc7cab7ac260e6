"""Whatever the bytes of a file: it is read or refused in a sentence; each regression was once a finding."""

from dataclasses import dataclass
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from bench.readers import Reader, attempt, readers
from station.exits import UsageProblem
from station.results.models import read_model
from station.settings import load_settings

NAMES = (
    "session.json",
    "manifest.json",
    "raw.log",
    "raw.log, sound checksums",
    "model file",
    "ladder.json",
    "diagnosis.json",
    "station.toml",
    "CSV",
    "MATLAB",
    "UFF58",
    "JSON",
    "text of a monitor",
    "lines of a board",
    "port",
    "expression",
)
NASTY = (
    b"", b"\0", b"\xff\xfe", b"null", b"NaN", b"-Infinity", b"1e400", b"-1", b"9" * 5000, b"1" + b"0" * 18, b'"',
    b"[" * 3000, b'{"a":' * 3000, b"(" * 3000, b"-" * 3000, b"\\ud800", "\u0663".encode(), b"\n", b"inf",
)  # fmt: skip


@pytest.fixture(scope="module")
def by_name(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Reader]:
    return {reader.name: reader for reader in readers(tmp_path_factory.mktemp("seeds"))}


@dataclass(frozen=True)
class Edit:
    """A piece of a file, by its place as a share of the length and its length, and what stands there instead."""

    place: float
    length: int
    new: bytes | None  # None doubles the piece


EDITS = st.lists(
    st.builds(
        Edit,
        st.floats(0.0, 1.0),
        st.sampled_from((0, 1, 4, 40, 4000)),
        st.sampled_from((None, *NASTY)) | st.binary(max_size=8),
    ),
    min_size=1,
    max_size=4,
)


def edited(seed: bytes, edits: list[Edit]) -> bytes:
    """A valid file with pieces replaced by something nasty, cut out or doubled."""
    for edit in edits:
        at = round(edit.place * len(seed))
        piece = seed[at : at + edit.length]
        seed = seed[:at] + (piece * 2 if edit.new is None else edit.new) + seed[at + len(piece) :]
    return seed


@pytest.mark.parametrize(
    "name", [name for name in NAMES if name != "MATLAB"]
)  # mangled by test_importing_garbage
@settings(max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(which=st.integers(0, 99), edits=EDITS)
def test_an_edited_file_is_read_or_refused_in_a_sentence(
    name: str,
    by_name: dict[str, Reader],
    tmp_path_factory: pytest.TempPathFactory,
    which: int,
    edits: list[Edit],
) -> None:
    reader = by_name[name]
    folder = tmp_path_factory.getbasetemp() / "read"
    folder.mkdir(exist_ok=True)
    attempt(reader, edited(reader.seeds[which % len(reader.seeds)], edits), folder)


def test_every_reader_takes_the_file_that_it_is_fuzzed_from(
    by_name: dict[str, Reader], tmp_path: Path
) -> None:
    for name in NAMES:
        assert attempt(by_name[name], by_name[name].seeds[0], tmp_path), name


@pytest.mark.parametrize(
    "text",
    [
        b"[specimen]\noperator = " + b"[" * 3000,
        b"[capture]\nrate = " + b"9" * 5000,
        b"[specimen]\nope" + b"-" * 5000 + b" = 1",
        b"\xff\xfe",
        b"a = 1\na = 2",
        b"#" * 2_000_000,
    ],
    ids=["deep", "long number", "long name", "not UTF-8", "twice", "large"],
)
def test_bad_settings_are_refused_in_one_short_sentence(tmp_path: Path, text: bytes) -> None:
    (tmp_path / "station.toml").write_bytes(text)
    with pytest.raises(UsageProblem, match=r"station\.toml") as refused:
        load_settings(tmp_path / "station.toml")
    assert len(str(refused.value)) < 500 + len(str(tmp_path))


def test_a_model_with_an_endless_name_is_refused_in_one_short_sentence(tmp_path: Path) -> None:
    (tmp_path / "m.json").write_bytes(b'{"' + b"x" * 5000 + b'": 1}')
    with pytest.raises(UsageProblem) as refused:
        read_model(tmp_path / "m.json")
    assert len(str(refused.value)) < 400 + len(str(tmp_path))


def test_channels_near_the_largest_number_raise_no_suspicion_and_no_warning() -> None:
    import numpy as np

    from daq.quality import wiring
    from daq.recording import Channel, Recording

    t = np.arange(300) / 256.0
    channels = Channel("x", "displacement", "m"), Channel("a", "acceleration", "m/s^2")
    samples = np.stack([1e300 * np.cos(25 * t), -1e300 * np.cos(25 * t)])
    assert not list(wiring(Recording(256.0, channels, samples, np.ones(300, dtype=bool))))


def test_a_data_file_that_holds_python_is_never_run(tmp_path: Path, by_name: dict[str, Reader]) -> None:
    mark = tmp_path / "ran"
    code = f"__import__('pathlib').Path({str(mark)!r}).touch()".encode()
    for reader in by_name.values():
        attempt(reader, code, tmp_path)
        attempt(reader, b"x = " + code, tmp_path)
    assert not mark.exists()
