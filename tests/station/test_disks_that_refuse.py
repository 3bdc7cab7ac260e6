"""Sessions that are not as they were written, that may not be written, and a disk that is full at an import."""

import errno
import os
import resource

import numpy as np
import pytest

from daq.storage import Lock, refused
from station.cli import run
from station.settings import Settings
from station.story.pipeline import silent
from station.workbench.tasks import look

pytestmark = pytest.mark.usefixtures("among_few")
T = np.arange(1200) / 100.0


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    moved = 9.0 * np.exp(-0.2 * T) * np.cos(2 * np.pi * 1.3 * T)
    noisy = moved + 0.01 * np.random.default_rng(1).standard_normal(len(T))
    np.savetxt("decay.csv", np.column_stack([T, noisy]), delimiter=",", header="t (s),x (mm)", comments="")
    return tmp_path


@pytest.mark.parametrize("command", ["identify", "compare", "report"])
def test_a_session_that_was_cut_says_so_before_anything_else(here, capsys, command):
    assert run(["import", "decay.csv"]) == 0
    raw = here / "sessions" / "decay" / "raw.log"
    os.truncate(raw, raw.stat().st_size * 2 // 3)
    capsys.readouterr()
    run([command, "decay"])
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("warning: decay does not agree with its manifest (raw.log: ")
    assert "station verify sessions/decay" in first


@pytest.mark.usefixtures("undrawn")
def test_page_and_report_certify_no_session_that_was_changed(here, capsys):
    assert run(["import", "decay.csv"]) == 0
    folder = here / "sessions" / "decay"
    with (folder / "raw.log").open("ab") as raw:
        raw.write(b"more")
    assert "does not agree with its manifest" in look(Settings(), silent, folder).note
    assert run(["report", "decay"]) == 0
    page = (folder / "results" / "report.html").read_text(encoding="utf-8")
    assert page.index("does not agree with its manifest") < page.index("<h2>Result")
    assert "every byte as it came" not in page
    assert "Verdict on the recording:</b> none" in page


@pytest.mark.usefixtures("undrawn")
def test_a_session_that_is_as_it_was_written_brings_no_warning(here, capsys):
    assert run(["identify", "decay.csv"]) == 0
    assert run(["compare", "decay"]) == 0
    assert run(["report", "decay"]) == 0
    assert "warning" not in capsys.readouterr().err
    assert not look(Settings(), silent, here / "sessions" / "decay").note
    page = (here / "sessions" / "decay" / "results" / "report.html").read_text(encoding="utf-8")
    assert "every byte as it came" in page


@pytest.mark.usefixtures("undrawn")
def test_of_a_session_that_may_not_be_written_results_are_told_and_not_kept(here, capsys, monkeypatch):
    assert run(["import", "decay.csv"]) == 0
    capsys.readouterr()

    def read_only(lock, wait_s=0.2):
        raise refused(lock.path, OSError(errno.EROFS, os.strerror(errno.EROFS)))

    monkeypatch.setattr(Lock, "acquire", read_only)
    written = ["report", "decay", "--output", "page.html"]
    for line in (["identify", "decay"], ["compare", "decay"], ["diagnose", "decay"], written):
        assert run(line) == 0
        told = capsys.readouterr()
        assert told.out
        assert told.err.count("what is found is not kept") == 1
    page = (here / "page.html").read_text(encoding="utf-8")
    assert len(page) > 10_000
    assert run(["refine", "decay", "--auto"]) == run(["refine", "decay"]) == run(["view", "decay"]) == 7
    assert not capsys.readouterr().out
    assert not list((here / "sessions" / "decay" / "results").iterdir())
    assert run(["report", "decay"]) == 7


def test_a_session_that_is_not_sealed_is_not_said_to_disagree_with_a_manifest(here, capsys):
    assert run(["import", "decay.csv"]) == 0
    (here / "sessions" / "decay" / "manifest.json").unlink()
    capsys.readouterr()
    run(["compare", "decay"])
    first = capsys.readouterr().err.splitlines()[0]
    assert first.startswith("warning: decay is not sealed: it is still being recorded, or was cut off; see `")
    assert "station recover sessions/decay" in first


@pytest.mark.skipif(os.name == "nt", reason="file size limits are POSIX")
def test_an_import_onto_a_full_disk_says_that_nothing_was_kept(here, capsys):
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
    try:
        assert run(["import", "decay.csv", "--session", "small"]) == 7
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    said = capsys.readouterr().err
    assert "the import failed, and nothing was kept: small/raw.log" in said
    assert "capture" not in said
    assert not (here / "small").exists()
