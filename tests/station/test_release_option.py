"""`station capture --release` takes a length with its unit, and says in one sentence why a rig cannot."""

import subprocess
import sys
from pathlib import Path

import pytest

from mocks.in_process import running
from station import exits
from station.exits import UsageProblem
from station.operations.new_session import capture_settings
from station.settings import Settings


def release_from(text: str | None) -> float | None:
    return capture_settings(Settings(), release=text).release_from


@pytest.mark.parametrize(
    ("text", "metres"),
    [("12mm", 0.012), ("-8 mm", -0.008), ("1.5cm", 0.015), ("+0.02 m", 0.02), (None, None)],
)
def test_a_length_with_its_unit_is_taken(text: str | None, metres: float | None) -> None:
    assert release_from(text) == pytest.approx(metres)


@pytest.mark.parametrize("text", ["12", "mm", "12 s", "far", "12 deg", ""])
def test_anything_else_is_refused_with_what_to_write(text: str) -> None:
    with pytest.raises(UsageProblem, match="write a length with its unit, as 12mm or -8mm"):
        release_from(text)


@pytest.mark.parametrize(
    ("board", "words"),
    [
        ((), "has no holder, so this rig cannot release itself"),
        (("--holder", "0,10"), "0 to 10 mm; nothing was moved"),
    ],
)
def test_a_rig_that_cannot_is_said_in_one_sentence(
    tmp_path: Path, board: tuple[str, ...], words: str
) -> None:
    with running("--tcp", "0", *board) as port:
        command = [
            sys.executable,
            "-m",
            "station",
            "capture",
            "--port",
            port,
            "--release",
            "-12mm",
            "--no-viewer",
        ]
        done = subprocess.run(
            [*command, "--session", str(tmp_path / "s")], capture_output=True, text=True, timeout=60
        )
    assert done.returncode == exits.USAGE
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "s").exists()
