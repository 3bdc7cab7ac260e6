"""A disk that fails under `station capture`: the session goes to the spare place and nothing is lost."""

import json
import shutil
import subprocess
import sys
import time
from pathlib import Path

from daq.session import Session, verify

ROOT = Path(__file__).parents[2]


def test_a_folder_deleted_in_mid_capture_moves_the_session_to_the_spare_place(tmp_path: Path) -> None:
    double = subprocess.Popen(
        [sys.executable, "-m", "mocks", "--tcp", "0", "--seed", "5"],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert double.stdout is not None
    assert double.stdin is not None
    port = double.stdout.readline().removeprefix("port: ").strip()
    options = ["--duration", "4", "--spare", tmp_path / "spare", "--no-viewer", "--json"]
    command = [
        sys.executable,
        "-m",
        "station",
        "capture",
        "--port",
        port,
        "--session",
        tmp_path / "s",
        *options,
    ]
    capture = subprocess.Popen(map(str, command), cwd=ROOT, stdout=subprocess.PIPE, text=True)
    try:
        while not (tmp_path / "s" / "raw.log").exists():
            assert capture.poll() is None
            time.sleep(0.05)
        time.sleep(1.0)
        shutil.rmtree(tmp_path / "s")
        said = json.loads(capture.communicate(timeout=60)[0])
    finally:
        capture.kill()
        capture.wait(10)
        double.terminate()
        double.communicate(timeout=10)
    session = Session.open(said["session"])
    assert session.folder.parent == tmp_path / "spare"
    assert capture.returncode == 0
    assert session.recording().valid.all()
    assert session.recording().samples.shape[1] == 5 * 256  # 1 s before the release and 4 s after it
    assert verify(session.folder).ok
