"""The C compiler of this machine, or a skip that says why there is no test."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
C_FOLDER = ROOT / "firmware_protocol" / "c"
HERE = Path(__file__).parent
STRICT = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
SANITIZE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def compiler(name: str = "cc") -> str:
    """The path of the compiler, or skip the test."""
    found = shutil.which(os.environ.get("CC", name) if name == "cc" else name)
    if found is None:
        pytest.skip(f"no C compiler ({name}) on this machine")
    return found


def build(out: Path, sources: list[Path], flags: list[str], name: str = "cc") -> Path:
    """Compile; fail with the compiler's own words."""
    command = [compiler(name), *flags, f"-I{C_FOLDER}", *map(str, sources), "-o", str(out), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return out
