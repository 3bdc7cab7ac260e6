import json
import os
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st
from scripted_board import RATE, decay

from daq.errors import (
    NotASession,
    OperatorError,
    SessionDamaged,
    SessionLocked,
    StationError,
    StorageError,
)
from daq.raw_log import Kind, RawLog
from daq.recording import Channel, Gap, Recording
from daq.session import (
    Session,
    SessionInfo,
    State,
    list_sessions,
    recover,
    unsealed_sessions,
    verify,
)
from daq.session_info import SensorInfo

CHANNELS = (
    Channel("Weg", "displacement", "m", 1e-6, -0.05, 0.05, 0.001, "LVDT 7", 0.01),
    Channel("a", "acceleration", "m/s^2"),
)


def example(n: int = 2048) -> Recording:
    valid = np.ones(n, dtype=bool)
    valid[100:110] = False
    return Recording(
        RATE, CHANNELS, decay(n, 100), valid, (Gap(100, 10, "blank"),), 0.01, 99, ("read by the importer",)
    )


@pytest.fixture
def session(tmp_path: Path) -> Session:
    source = tmp_path / "mine.csv"
    source.write_text("time_s,displacement_m\n0,0\n")
    info = SessionInfo(operator="Ada", mass_kg=21.36, mass_std_kg=0.01)
    return Session.create_imported(tmp_path / "s", example(), source, info)


def test_an_imported_recording_comes_back_bit_by_bit(session: Session) -> None:
    given_, read = example(), Session.open(session.folder).recording()
    assert np.array_equal(read.samples[:, given_.valid], given_.samples[:, given_.valid])
    assert np.array_equal(read.valid, given_.valid)
    for name in ("rate", "channels", "gaps", "rate_std", "trigger", "notes"):
        assert getattr(read, name) == getattr(given_, name)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.integers(1, 5),
    st.integers(1, 200),
    st.floats(1e-3, 1e6),
    st.integers(0, 2**32 - 1),
)
def test_any_recording_survives(
    tmp_path_factory: pytest.TempPathFactory, channels: int, n: int, rate: float, seed: int
) -> None:
    random = np.random.default_rng(seed)
    samples = random.normal(size=(channels, n)) * 10.0 ** random.integers(-300, 300, (channels, n))
    samples[random.random((channels, n)) < 0.05] = -0.0
    valid = random.random(n) < 0.8
    valid[random.integers(n)] = True
    names = tuple(Channel(f"Kanal {i} \u00b5", "other", "V") for i in range(channels))
    folder = tmp_path_factory.mktemp("any") / "s"
    Session.create_imported(folder, Recording(rate, names, samples, valid), None)
    read = Session.open(folder).recording()
    assert read.rate == rate
    assert read.channels == names
    assert np.array_equal(read.valid, valid)
    assert read.samples[:, valid].tobytes() == samples[:, valid].tobytes()


def test_the_source_and_the_metadata_are_kept(session: Session) -> None:
    opened = Session.open(session.folder)
    assert opened.source_file is not None
    assert opened.source_file.read_text().startswith("time_s")
    assert opened.info.state is State.SEALED
    assert (opened.info.operator, opened.info.mass_kg) == ("Ada", 21.36)
    assert opened.info.sensors[0] == SensorInfo(channel="Weg", sensor="LVDT 7", uncertainty=0.01)


def test_a_sealed_session_verifies(session: Session) -> None:
    session.write_result("wavelet.json", "{}")
    session.update(specimen="the new spring")
    result = verify(session.folder)
    assert result.problems == ()
    assert result.files == 5


def every_file(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_one_flipped_bit_anywhere_is_found(session: Session, data: st.DataObject) -> None:
    path = data.draw(st.sampled_from(every_file(session.folder)))
    content = path.read_bytes()
    at = data.draw(st.integers(0, len(content) - 1))
    flipped = bytearray(content)
    flipped[at] ^= 1 << data.draw(st.integers(0, 7))
    path.write_bytes(bytes(flipped))
    try:
        assert not verify(session.folder).ok
    finally:
        path.write_bytes(content)


def test_a_missing_and_an_added_file_are_found(session: Session) -> None:
    (session.folder / "raw.log").rename(session.folder / "raw.old")
    problems = verify(session.folder).problems
    assert any(p.startswith("raw.log") for p in problems)
    assert any("raw.old: not in the manifest" in p for p in problems)


def test_a_manifest_cannot_name_a_file_outside(session: Session) -> None:
    from daq.manifest import entry, read_manifest, write_manifest

    outside = session.folder.parent / "secret"
    outside.write_text("secret")
    manifest = read_manifest(session.folder)
    files = {**manifest.files, "../secret": entry(b"secret")}
    write_manifest(session.folder, manifest.model_copy(update={"files": files}))
    assert any("outside the session" in problem for problem in verify(session.folder).problems)


def test_a_folder_that_holds_something_is_not_overwritten(session: Session, tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in every_file(session.folder)}
    with pytest.raises(OperatorError, match="nothing was overwritten"):
        Session.create_imported(session.folder, example(), None)
    assert {path: path.read_bytes() for path in every_file(session.folder)} == before
    with pytest.raises(OperatorError):
        Session.create_imported(tmp_path, example(), None)


@pytest.mark.parametrize("name", ["../a", "a/b", "", ".", "..", "a\\b", "C:x", "a\0b"])
def test_a_result_cannot_leave_its_folder(session: Session, name: str) -> None:
    with pytest.raises(OperatorError):
        session.write_result(name, "x")


def test_metadata_out_of_range_are_refused_and_nothing_changes(session: Session) -> None:
    with pytest.raises(OperatorError, match="mass_kg"):
        session.update(mass_kg=-1.0)
    assert Session.open(session.folder).info.mass_kg == 21.36


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"mass_kg": "x"}', '{"format": 99}', "\x00\xff"])
def test_damaged_metadata_are_refused_in_words(session: Session, text: str) -> None:
    (session.folder / "session.json").write_text(text, encoding="latin-1")
    with pytest.raises(SessionDamaged, match="session"):
        Session.open(session.folder)


@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_whatever_a_session_holds_it_is_read_or_refused_in_words(
    session: Session, data: st.DataObject
) -> None:
    path = data.draw(st.sampled_from(every_file(session.folder)))
    content = path.read_bytes()
    try:
        path.write_bytes(data.draw(st.binary(max_size=300)) + content[data.draw(st.integers(0, 400)) :])
        opened = Session.open(session.folder)
        opened.recording()
        opened.manifest()
        said = "read"
    except StationError as refused:
        said = str(refused)
    finally:
        path.write_bytes(content)
    assert said
    assert "Traceback" not in said


def test_a_link_in_place_of_a_file_is_not_followed(session: Session) -> None:
    (session.folder / "raw.log").unlink()
    try:
        (session.folder / "raw.log").symlink_to("/dev/zero")
    except OSError:
        pytest.skip("no links on this system")
    with pytest.raises(StorageError):
        session.recording()
    assert not verify(session.folder).ok


def unsealed(folder: Path) -> tuple[Session, RawLog]:
    """A session as a killed capture leaves it."""
    from daq.import_log import import_log

    log = import_log(example())
    return Session.create(folder, SessionInfo(specimen="spring"), log), log


def test_a_session_that_is_being_written_is_locked(tmp_path: Path) -> None:
    session, log = unsealed(tmp_path / "s")
    assert unsealed_sessions(tmp_path) == ()
    with pytest.raises(SessionLocked, match="another process"):
        recover(tmp_path / "s")
    log.close()
    session.release()
    assert unsealed_sessions(tmp_path) == (tmp_path / "s",)


def test_an_unsealed_session_is_recovered_whole(tmp_path: Path) -> None:
    session, log = unsealed(tmp_path / "s")
    log.close()
    session.release()
    with (tmp_path / "s" / "raw.log").open("ab") as file:
        file.write(b"\xf5\xdb half a record")
    recovered = recover(tmp_path / "s")
    assert recovered.info.state is State.RECOVERED
    assert "bytes cut" in recovered.info.reason
    assert verify(tmp_path / "s").ok
    assert recovered.recording().samples.shape == (2, 2048)
    assert unsealed_sessions(tmp_path) == ()
    assert recover(tmp_path / "s").info == recovered.info


def test_a_session_without_its_metadata_is_recovered_from_the_log(tmp_path: Path) -> None:
    session, log = unsealed(tmp_path / "s")
    log.close()
    session.release()
    (tmp_path / "s" / "session.json").write_bytes(b"\0" * 50)
    assert recover(tmp_path / "s").info.specimen == "spring"


def test_a_log_without_a_sample_is_recovered_and_rejected(tmp_path: Path) -> None:
    log = RawLog()
    log.append(Kind.RECEIVED, b"noise")
    session = Session.create(tmp_path / "s", SessionInfo(), log)
    log.close()
    session.release()
    assert recover(tmp_path / "s").info.verdict == "REJECT"


def test_what_is_no_session_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(NotASession, match="is no session"):
        Session.open(tmp_path)
    with pytest.raises(NotASession, match="nothing to recover"):
        recover(tmp_path)
    assert not verify(tmp_path).ok


def test_sessions_are_listed_oldest_first(tmp_path: Path) -> None:
    for day in (3, 1, 2):
        info = SessionInfo(created=datetime(2020, 1, day, tzinfo=UTC))
        Session.create_imported(tmp_path / f"s{9 - day}", example(64 + 256), None, info)
    assert [summary.folder.name for summary in list_sessions(tmp_path)] == ["s8", "s7", "s6"]


def test_a_list_says_what_cannot_be_read(tmp_path: Path, session: Session) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "session.json").write_text("{")
    (tmp_path / "unrelated").mkdir()
    found = {s.folder.name: s.problem for s in list_sessions(tmp_path)}
    assert set(found) == {"s", "broken"}
    assert found["s"] == ""
    assert "recover" in found["broken"]


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs a user whom permissions bind")
def test_a_read_only_folder_is_refused_in_words(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(StorageError, match="name another folder"):
            Session.create_imported(tmp_path / "s", example(), None)
    finally:
        tmp_path.chmod(0o700)


def test_a_session_cannot_be_made_under_a_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(StationError):
        Session.create_imported(tmp_path / "file" / "s", example(), None)


def test_session_json_is_readable_json(session: Session) -> None:
    assert json.loads((session.folder / "session.json").read_text())["state"] == "sealed"
