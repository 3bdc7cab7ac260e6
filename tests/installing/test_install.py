"""Installing: what it shows, and the launcher that a new shell finds."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement

import install

ROOT = Path(__file__).resolve().parents[2]
SYSTEM = "/usr/bin:/bin"


@pytest.fixture
def home(tmp_path):
    """A home with an environment beside it whose `station` says what it was asked."""
    program = tmp_path / "venv" / "bin" / "station"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\necho "asked: $*"\n')
    program.chmod(0o755)
    (tmp_path / "home").mkdir()
    return tmp_path / "home"


def make(target, home, path):
    """Run a target of the Makefile as somebody else, on an environment that needs no installation."""
    venv = home.parent / "venv"
    return subprocess.run(
        [shutil.which("make"), "-s", "-o", f"{venv}/.installed", target, f"VENV={venv}", f"PYTHON={sys.executable}"],
        cwd=ROOT, env={"HOME": str(home), "PATH": path}, capture_output=True, text=True, timeout=60, check=True,
    ).stdout  # fmt: skip


def in_a_new_shell(command, home, path):
    return subprocess.run(
        ["/bin/sh", "-c", command], env={"HOME": str(home), "PATH": path}, capture_output=True, text=True,
        timeout=60, check=False,
    )  # fmt: skip


@pytest.mark.skipif(not shutil.which("make"), reason="make is not installed here")
@pytest.mark.parametrize("place", [".local/bin", "bin"])
def test_the_launcher_is_found_by_a_new_shell(home, place):
    path = f"{home / place}:{SYSTEM}"
    said = make("launcher", home, path)
    assert len(said.splitlines()) == 1
    assert str(home / place / "station") in said
    assert in_a_new_shell("station compare 'a b'", home, path).stdout == "asked: compare a b\n"
    make("launcher", home, path)  # a second time is no other


@pytest.mark.skipif(not shutil.which("make"), reason="make is not installed here")
def test_where_the_shell_looks_nowhere_the_line_to_type_is_printed_and_works(home):
    said = make("launcher", home, SYSTEM)
    assert not list(home.iterdir())
    line = re.search(r"export PATH=.*", said).group()
    assert in_a_new_shell(f"{line}; station list", home, SYSTEM).stdout == "asked: list\n"


@pytest.mark.skipif(not shutil.which("make"), reason="make is not installed here")
def test_somebody_elses_station_is_left_alone(home):
    theirs = home / ".local" / "bin" / "station"
    theirs.parent.mkdir(parents=True)
    theirs.write_text("#!/bin/sh\necho radio\n")
    path = f"{theirs.parent}:{SYSTEM}"
    assert "export PATH=" in make("launcher", home, path)
    assert theirs.read_text() == "#!/bin/sh\necho radio\n"


def test_removing_takes_the_launcher_of_this_clone_and_no_other(home, monkeypatch, capsys):
    folder = home / ".local" / "bin"
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr(install, "BIN", home.parent / "venv" / "bin")
    install.place_launcher()
    placed = (folder / "station").read_text()
    monkeypatch.setattr(install, "BIN", home.parent / "another" / "bin")
    install.remove_launcher()
    assert (folder / "station").read_text() == placed
    monkeypatch.setattr(install, "BIN", home.parent / "venv" / "bin")
    install.remove_launcher()
    assert not (folder / "station").exists()


def test_what_pip_says_becomes_few_and_plain_words():
    said = """\
Obtaining file:///somewhere
  Installing build dependencies: started
Collecting numpy>=2.0 (from free-decay-station==0.1.0)
  Using cached numpy-2.3.0-cp313-cp313-manylinux_2_28_x86_64.whl.metadata (62 kB)
Collecting llvmlite<0.45,>=0.44.0 (from numba>=0.61->free-decay-station==0.1.0)
Collecting rerun-sdk==0.41.* (from free-decay-station==0.1.0)
Downloading numpy-2.3.0-cp313-cp313-manylinux_2_28_x86_64.whl (16.6 MB)
   ━━━━━━━━━━━━━━━━ 16.6/16.6 MB 100 MB/s eta 0:00:00
Downloading cobs-1.2.1-py3-none-any.whl (13 kB)
Installing collected packages: numpy, llvmlite, rerun-sdk
"""
    progress = install.Progress()
    shown = [text for text in map(progress.hear, said.splitlines()) if text]
    assert [text.split() for text in shown] == [
        ["numpy", "arrays"],
        ["rerun-sdk", "the", "viewer"],
        ["downloading", "17", "MB", "of", "numpy"],
        ["putting", "3", "packages", "in", "place;", "this", "takes", "a", "minute"],
    ]


def test_every_dependency_says_what_it_is_for():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = {re.match(r"[\w.-]+", text).group().lower() for text in project["dependencies"]}
    assert named <= set(install.reasons())


def test_the_demo_needs_no_tools_of_tests():
    wanted = subprocess.run(
        [shutil.which("make") or "make", "-n", "demo", "VENV=nowhere"], cwd=ROOT, env=os.environ,
        capture_output=True, text=True, timeout=60, check=True,
    ).stdout  # fmt: skip
    assert "install.py" in wanted
    assert "--dev" not in wanted


def test_what_is_installed_is_kept_by_name_and_version_and_is_what_the_tests_run_with():
    lines = install.CONSTRAINTS.read_text(encoding="utf-8").splitlines()
    assert all(re.fullmatch(r"[\w.-]+==\d[\w.+!]*", line) for line in lines)
    kept = {install._plain(name): version for name, _, version in (line.partition("==") for line in lines)}
    assert len(kept) == len(lines)
    project = tomllib.loads((install.HERE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for requirement in map(Requirement, [*project["dependencies"], *project["optional-dependencies"]["dev"]]):
        assert requirement.specifier.contains(kept[install._plain(requirement.name)]), requirement
    others = {
        f"{name} {version(name)}"
        for name, known in kept.items()
        if find(name) is not None and version(name) != known
    }
    if others:
        pytest.skip(
            f"other versions are installed, as where this Python has none of those kept: {sorted(others)}"
        )


def find(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
