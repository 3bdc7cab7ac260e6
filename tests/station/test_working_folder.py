"""A working folder in which a stranger has planted every module and every settings file that something might read."""

import subprocess
import sys
from importlib.metadata import packages_distributions
from pathlib import Path

import numpy as np
import pytest

from daq.recording import Channel, Recording
from daq.session import Session

PWNED = "open({mark!r}, 'a').write({name!r} + chr(10)); raise SystemExit('planted: ' + {name!r})\n"
BEGIN = "import sys; sys.path.pop(0); "  # as the script `station` begins: nothing of the working folder is on the path
STATION = BEGIN + "from station.cli import main; main()"
LIMIT_S = 240  # to end a hang; what is run takes some seconds


@pytest.fixture
def planted(tmp_path: Path) -> Path:
    """A folder of sessions with code under the name of every module, and settings of every library that looks for some."""
    folder = tmp_path / "from a stranger"
    folder.mkdir()
    mark = str(tmp_path / "planted_code_ran")
    for name in {
        *sys.stdlib_module_names,
        *packages_distributions(),
        "sitecustomize",
        "usercustomize",
        "mocks",
    }:
        if name.isidentifier() and name not in ("station", "daq", "identify", "firmware_protocol"):
            (folder / f"{name}.py").write_text(PWNED.format(mark=mark, name=name))
    (folder / ".numba_config.yaml").write_text(f"disable_jit: 1\ncache_dir: {folder / 'kept'}\n")
    (folder / "matplotlibrc").write_text("backend: module://planted_backend\nlines.linewidth: many\n")
    (folder / ".env").write_text("NUMBA_DISABLE_JIT=1\nHOST=0.0.0.0\n")
    for place in (place for place in sys.path if place and not Path(place).is_absolute()):
        (folder / place / "planted-1.dist-info").mkdir(parents=True)
        entry = "[numba_extensions]\ninit = planted_extension:init\n"
        (folder / place / "planted-1.dist-info" / "entry_points.txt").write_text(entry)
        (folder / place / "planted_extension.py").write_text(PWNED.format(mark=mark, name="entry point"))
    t = np.arange(1024) / 256.0
    samples = 0.02 * np.exp(-0.2 * t) * np.vstack([np.cos(25 * t), -625 * np.cos(25 * t)])
    samples += 1e-6 * np.random.default_rng(5).standard_normal(samples.shape) * [[1.0], [1000.0]]
    channels = (Channel("u", "displacement", "m"), Channel("a", "acceleration", "m/s^2"))
    Session.create_imported(
        folder / "s", Recording(256.0, channels, samples, np.ones(1024, dtype=bool)), None
    )
    return folder


def ran(folder: Path, code: str, *arguments: str) -> str:
    """Run Python in the folder and return what it said; no planted code may have run and no settings have been used."""
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LIMIT_S)
    mark = folder.parent / "planted_code_ran"
    assert not mark.exists(), mark.read_text()
    assert done.returncode == 0, done.stderr
    assert "planted" not in done.stderr
    assert "matplotlibrc" not in done.stderr  # whose bad value it would tell
    assert not (folder / "kept").exists()
    return done.stdout


@pytest.mark.slow
def test_a_report_with_its_pictures_reads_nothing_planted(planted: Path) -> None:
    ran(planted, STATION, "report", "s")


@pytest.mark.slow
def test_the_workers_of_a_campaign_import_nothing_planted(planted: Path) -> None:
    ran(planted, STATION, "campaign", ".", "--workers", "1")


def test_the_simulated_board_is_the_programs_own(planted: Path) -> None:
    code = (
        BEGIN + "from station.working_folder import import_nothing_from_it as blind; blind(); "
        "from station.operations.simulated_board import simulated_board as board\n"
        "with board(1, 1.0) as port: print(port)"
    )
    assert ran(planted, code).startswith("socket://")


def test_a_script_that_imports_identify_gets_no_settings_of_numba(planted: Path) -> None:
    code = BEGIN + (
        "import identify.effects.compiled, warnings; from numba.core import config; "
        "warnings.simplefilter('error'); config.reload_config(); "
        "print(config.DISABLE_JIT, repr(config.CACHE_DIR))"
    )
    assert ran(planted, code) == "0 ''\n"
