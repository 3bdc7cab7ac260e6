import os
import resource
import shutil
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from daq.errors import OperatorError, SessionDamaged, StorageError
from daq.raw_log import HEAD_SIZE, MAGIC, Kind, RawLog, Record, pack, read, unpack

RECORDS = st.lists(
    st.builds(Record, st.sampled_from(Kind), st.floats(allow_nan=False), st.binary(max_size=60)),
    max_size=12,
)


def written(records: list[Record]) -> bytes:
    return MAGIC + b"".join(pack(record) for record in records)


@given(RECORDS)
def test_what_was_written_is_read(records: list[Record]) -> None:
    raw = unpack(written(records))
    assert list(raw.records) == records
    assert (raw.damaged, raw.cut) == (0, 0)


@given(RECORDS, st.data())
def test_a_log_cut_anywhere_keeps_its_whole_records(records: list[Record], data: st.DataObject) -> None:
    whole = written(records)
    end = data.draw(st.integers(len(MAGIC), len(whole)))
    sizes, at = [], len(MAGIC)
    for record in records:
        at += HEAD_SIZE + len(record.payload)
        sizes.append(at)
    kept = sum(size <= end for size in sizes)
    raw = unpack(whole[:end])
    assert list(raw.records) == records[:kept]
    assert raw.cut == end - (sizes[kept - 1] if kept else len(MAGIC))


@given(RECORDS.filter(lambda r: len(r) > 0), st.data())
def test_a_flipped_bit_costs_one_record_and_no_other(records: list[Record], data: st.DataObject) -> None:
    whole = bytearray(written(records))
    at = data.draw(st.integers(len(MAGIC), len(whole) - 1))
    whole[at] ^= 1 << data.draw(st.integers(0, 7))
    found = list(unpack(bytes(whole)).records)
    assert len(found) >= len(records) - 1
    assert all(record in records for record in found)


@settings(max_examples=100)
@given(st.binary(max_size=4000))
def test_garbage_neither_raises_nor_makes_records(garbage: bytes) -> None:
    raw = unpack(MAGIC + garbage)
    assert raw.records == ()


def test_a_megabyte_of_markers_is_read_in_no_time() -> None:
    raw = unpack(MAGIC + b"\xf5\xdb" * (1 << 19))
    assert raw.records == ()


def test_another_file_is_refused_in_words() -> None:
    with pytest.raises(SessionDamaged, match="does not begin as one"):
        unpack(b"time_s,displacement_m\n")


def test_records_in_memory_reach_the_file_when_there_is_one(tmp_path: Path) -> None:
    log = RawLog()
    log.append(Kind.RECEIVED, b"before", when=1.0)
    log.store(tmp_path / "raw.log")
    log.append(Kind.SENT, b"after", when=2.0)
    log.close()
    assert [r.payload for r in read(tmp_path / "raw.log").records] == [b"before", b"after"]
    assert (tmp_path / "raw.log").read_bytes() == log.data


def test_a_record_is_in_the_file_before_anything_is_synced(tmp_path: Path) -> None:
    log = RawLog()
    log.store(tmp_path / "raw.log")
    log.append(Kind.RECEIVED, b"now")
    assert read(tmp_path / "raw.log").records[-1].payload == b"now"
    log.close()


def test_an_existing_file_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "raw.log").write_text("mine")
    with pytest.raises(OperatorError, match="nothing was overwritten"):
        RawLog().store(tmp_path / "raw.log")
    assert (tmp_path / "raw.log").read_text() == "mine"


def test_a_folder_that_vanishes_is_noticed_and_nothing_is_lost(tmp_path: Path) -> None:
    folder = tmp_path / "gone"
    folder.mkdir()
    log = RawLog()
    log.store(folder / "raw.log")
    log.append(Kind.RECEIVED, b"one", when=1.0)
    shutil.rmtree(folder)
    log.append(Kind.RECEIVED, b"two", when=2.0)
    log.sync()
    assert isinstance(log.failure, StorageError)
    log.store(tmp_path / "raw.log")
    log.close()
    assert [r.payload for r in read(tmp_path / "raw.log").records] == [b"one", b"two"]


@pytest.mark.skipif(os.name == "nt", reason="file size limits are POSIX")
def test_a_full_disk_leaves_everything_in_memory(tmp_path: Path) -> None:
    log = RawLog()
    log.store(tmp_path / "small.log")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        for i in range(100):
            log.append(Kind.RECEIVED, bytes([i]) * 100, when=float(i))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert log.failure is not None
    sentence = f"{tmp_path / 'small.log'}: File too large; check the disk or name another folder"
    assert str(log.failure) == sentence
    log.store(tmp_path / "large.log")
    log.close()
    assert len(read(tmp_path / "large.log").records) == 100
    assert all(r.payload == bytes([i]) * 100 for i, r in enumerate(read(tmp_path / "small.log").records))
