"""The wheel: built from the source distribution and installed elsewhere, it runs without the clone."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LEFT_BEHIND = (".*", "tests", "bench", "docs", "build", "site", "sessions", "*.egg-info", "__pycache__")

pytestmark = pytest.mark.slow


def done(*command, cwd):
    """Run a program that sees nothing of this clone; return what it printed."""
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "PYTEST"))
    }
    ended = subprocess.run(
        [str(part) for part in command], cwd=cwd, env=environment, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    return ended.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The programs of an environment that has the wheel, and the packages that it needs from this one."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(ROOT, folder / "source", ignore=shutil.ignore_patterns(*LEFT_BEHIND))
    done(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, folder / "source", cwd=folder)
    shutil.rmtree(folder / "source")
    venv.create(folder / "env")
    inside = {"base": str(folder / "env"), "platbase": str(folder / "env")}
    packages = Path(sysconfig.get_path("purelib", vars=inside))
    # A path in a .pth file is searched, but the .pth files there, and so the editable station, are not.
    (packages / "needed.pth").write_text(sysconfig.get_path("purelib"))
    programs = Path(sysconfig.get_path("scripts", vars=inside))
    wheel = next(folder.glob("*.whl"))
    pip = (sys.executable, "-m", "pip", "--python", programs / "python")
    done(*pip, "install", "--quiet", "--no-index", "--no-deps", wheel, cwd=folder)
    return programs


def test_the_demo_runs_outside_the_clone_with_the_board_that_is_installed(installed, tmp_path):
    where = "import station, mocks; print(station.__file__, mocks.__file__)"
    assert str(ROOT) not in done(installed / "python", "-c", where, cwd=tmp_path)
    folder = tmp_path / "demo"
    demo = ("demo", "--speed", "0", "--no-viewer", "--session", folder)
    assert "13149" in done(installed / "station", *demo, cwd=tmp_path)  # N/m, as the board was made with
    assert (folder / "results" / "identification.json").is_file()
    page = tmp_path / "report.html"
    done(installed / "station", "report", folder, "--output", page, cwd=tmp_path)
    assert "<html" in page.read_text(encoding="utf-8")


def firmware(package):
    """The files of the boards' side, in C, by their places in the package."""
    return {
        p.relative_to(package).as_posix()
        for p in package.rglob("*")
        if p.suffix in (".c", ".h", ".ino", ".ld")
    }


def test_the_examples_and_the_firmware_come_with_it(installed, tmp_path):
    told = json.loads(done(installed / "station", "demo", "--example", "ship_roll", "--json", cwd=tmp_path))
    assert Path(told["session"]).name == "ship_roll"
    where = done(installed / "python", "-c", "import firmware_protocol as f; print(f.__file__)", cwd=tmp_path)
    source, found = (firmware(Path(package)) for package in (ROOT / "firmware_protocol", Path(where).parent))
    assert found == source


def test_the_page_in_the_browser_has_its_files(installed, tmp_path):
    folder = "import station.workbench as w, pathlib as p; print(p.Path(w.__file__).parent / 'static')"
    static = Path(done(installed / "python", "-c", folder, cwd=tmp_path).strip())
    source = ROOT / "station" / "workbench" / "static"
    assert {path.name for path in static.iterdir()} == {path.name for path in source.iterdir()}
