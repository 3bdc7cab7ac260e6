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

PACKAGES = ("firmware_protocol", "daq", "identify", "station", "mocks")

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
    done(*pip, "install", "--quiet", "--no-index", "--no-deps", "--no-compile", wheel, cwd=folder)
    for name in PACKAGES:
        bring_what_numba_compiled(ROOT / name, packages / name)
    return programs


def bring_what_numba_compiled(source, installed):
    """Compiling the same functions again takes half a minute; numba asks for the time and the size of a source only."""
    for module in source.rglob("*.py"):
        place, seen = installed / module.relative_to(source), module.stat()
        if place.exists():
            os.utime(place, ns=(seen.st_atime_ns, seen.st_mtime_ns))
    for compiled in source.rglob("__pycache__/*.nb?"):
        place = installed / compiled.relative_to(source)
        place.parent.mkdir(exist_ok=True)
        shutil.copyfile(compiled, place)


def test_the_demo_runs_outside_the_clone_with_the_board_that_is_installed(installed, tmp_path):
    folder = tmp_path / "demo"
    demo = ("demo", "--speed", "0", "--no-viewer", "--session", folder)
    assert "13149" in done(installed / "station", *demo, cwd=tmp_path)  # N/m, as the board was made with
    assert (folder / "results" / "identification.json").is_file()


WHERE = """
import importlib, json
from station.operations.examples import examples_folder
packages = {name: importlib.import_module(name).__path__[0] for name in PACKAGES}
print(json.dumps(packages | {"examples": str(examples_folder())}))
"""


def files(folder):
    """The files below a folder, by their places in it, but what Python and numba compiled."""
    return {
        path.relative_to(folder).as_posix()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts and not path.name.startswith(".")
    }


def test_every_module_and_file_of_the_packages_and_the_examples_come_with_it(installed, tmp_path):
    """The C side, the page in the browser and the report's are files beside the modules that read them."""
    code = WHERE.replace("PACKAGES", repr(PACKAGES))
    places = json.loads(done(installed / "python", "-c", code, cwd=tmp_path))
    assert not [place for place in places.values() if place.startswith(str(ROOT))]
    for name in PACKAGES:
        assert files(Path(places[name])) == files(ROOT / name)
    assert files(ROOT / "examples") - {"make.py"} == files(Path(places["examples"]))
