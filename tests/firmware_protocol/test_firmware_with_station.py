"""The station records the release of the example firmware and finds what its C source put in."""

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest
from c_compiler import C_FOLDER, STRICT, build

from station.cli import run

SOURCES = [C_FOLDER / name for name in ("main.c", "board.c", "hardware_host.c")]
STIFFNESS, DRY, VISCOUS, LAG = 13115.0, 0.13, 0.277, 0.0013


@pytest.fixture
def port(tmp_path: Path) -> Iterator[str]:
    program = build(tmp_path / "firmware", SOURCES, [*STRICT, "-O2"])
    board = subprocess.Popen(
        [program, "--rest", "5"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert board.stdout is not None
    yield board.stdout.readline().removeprefix("port: ").strip()
    board.communicate(timeout=10)
    assert board.returncode == 0


@pytest.mark.slow
@pytest.mark.usefixtures("unrendered")
def test_the_station_finds_the_physics_of_an_independent_board(
    port: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["capture", "--port", port, "--session", str(tmp_path / "release")]
    code = run([*command, "--mass", "21.36", "--no-viewer", "--json"])
    said = capsys.readouterr()
    assert code == 0, said.err
    result = json.loads(said.out)
    assert result["verdict"]["word"] == "OK", result["verdict"]
    found = result["identification"]
    assert found["record"]["lost_samples"] == 0
    lag = found["alignment"]["lag_s"]
    # The Cramer-Rao bound at this noise is 2.6 us; five times that.
    assert lag["value"] == pytest.approx(LAG, abs=13e-6)
    for method in ("wavelet", "restoring_force"):
        dry, viscous = (term["value"] for term in found[method]["damping"])
        # What one release must reach: three times the rms errors that the benchmark allows.
        assert found[method]["stiffness"]["value"] == pytest.approx(STIFFNESS, rel=1.2e-3), method
        assert dry == pytest.approx(DRY, rel=0.018), method
        assert viscous == pytest.approx(VISCOUS, rel=0.036), method
