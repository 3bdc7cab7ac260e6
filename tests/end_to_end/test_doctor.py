"""`station doctor` on a sound board, on faulty ones, and on none."""

import contextlib
import fcntl
import io
import json
import os
from pathlib import Path
from unittest import mock

import pytest
from fault_bench import board

from daq.ports import holders, latency_ms
from station import cli

pytestmark = pytest.mark.skipif(os.name == "nt", reason="this system has no pty")


def doctor(*arguments: str) -> tuple[int, dict[str, tuple[str, str]], str]:
    """Return exit code, {check: (grade, found)} and what the terminal would show of the same."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(io.StringIO()):
        code = cli.run(["doctor", *arguments, "--json"])
    findings = json.loads(printed.getvalue())["findings"]
    assert all(f["remedy"] for f in findings if f["grade"] == "FAIL")
    return code, {f["check"]: (f["grade"], f["found"]) for f in findings}, printed.getvalue()


def test_a_sound_board_passes_in_real_time_and_fits_80_columns() -> None:
    printed = io.StringIO()
    with board("pty", "--seed", "5") as port, contextlib.redirect_stdout(printed):
        code = cli.run(["doctor", "--port", port])
    assert code == 0
    lines = printed.getvalue().splitlines()
    assert max(map(len, lines)) <= 80
    assert not any(line.startswith("FAIL") for line in lines)
    assert any(line.split()[:2] == ["PASS", "rate"] for line in lines)


@pytest.mark.parametrize(
    ("fault", "check", "word"),
    [
        ("dead-channel:1", "acceleration", "span 0 m/s^2"),
        ("wrong-version", "board", "version 2"),
        ("stall:30@1", "board", "2 s"),
        ("wrong-description", "board", "described"),
    ],
)
def test_a_fault_fails_with_a_remedy(fault: str, check: str, word: str) -> None:
    with board("pty", "--seed", "5", "--speed", "16", "--fault", fault) as port:
        code, found, _ = doctor("--port", port, "--seconds", "8")
    assert code == 3
    assert found[check][0] == "FAIL"
    assert word in found[check][1]


def test_a_busy_port_is_reported_with_the_program_that_has_it() -> None:
    with board("pty", "--seed", "5") as port:
        descriptor = os.open(port, os.O_RDWR | os.O_NOCTTY)
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        try:
            code, found, _ = doctor("--port", port)
        finally:
            os.close(descriptor)
    assert code == 3
    assert "another program has this port" in found["board"][1]


def test_a_port_without_permission_fails() -> None:
    with mock.patch("daq.port.serial.serial_for_url", side_effect=PermissionError(13, "Permission denied")):
        code, found, _ = doctor("--port", "/dev/ttyS9")
    assert (code, found["board"]) == (
        3,
        ("FAIL", "/dev/ttyS9: you have no permission to open this port"),
    )


def test_a_port_that_is_not_there_fails() -> None:
    code, found, _ = doctor("--port", "/dev/does-not-exist")
    assert (code, found["board"]) == (3, ("FAIL", "/dev/does-not-exist: there is no such port"))


def test_the_facts_of_a_port_come_from_the_system(tmp_path: Path) -> None:
    device = tmp_path / "ttyX"
    device.touch()
    (tmp_path / "proc" / "4711" / "fd").mkdir(parents=True)
    (tmp_path / "proc" / "4711" / "comm").write_text("minicom\n")
    (tmp_path / "proc" / "4711" / "fd" / "3").symlink_to(device)
    (tmp_path / "tty" / "ttyX" / "device").mkdir(parents=True)
    (tmp_path / "tty" / "ttyX" / "device" / "latency_timer").write_text("16\n")
    assert holders(str(device), tmp_path / "proc") == (("minicom", 4711),)
    assert latency_ms(str(device), tmp_path / "tty") == 16
    assert (holders("socket://localhost:5000"), latency_ms("socket://localhost:5000")) == ((), None)
    assert latency_ms(f"rfc2217://lab/{device.name}", tmp_path / "tty") is None


def test_no_port_at_all_is_a_warning() -> None:
    with mock.patch("daq.ports.system_ports", return_value=()):
        code, found, _ = doctor()
    assert (code, found["ports"][0]) == (0, "WARN")
