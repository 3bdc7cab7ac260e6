import os
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import pytest

from daq.errors import LinkLost, PortBusy, PortError
from daq.port import Port, SerialPort, open_port
from daq.port_names import fault_of

pty_only = pytest.mark.skipif(os.name == "nt", reason="this system has no pty")


def read_often(port: Port) -> None:
    for _ in range(10):
        port.read()


def write_often(port: Port) -> None:
    for _ in range(4000):
        port.write(bytes(1 << 16))


@pytest.fixture
def pty() -> "tuple[int, str]":
    import tty

    master, slave = os.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    os.close(slave)
    yield master, name  # type: ignore[misc]
    with suppress(OSError):
        os.close(master)


@pty_only
def test_bytes_go_both_ways_over_a_pty(pty: "tuple[int, str]") -> None:
    master, name = pty
    port = open_port(name)
    port.write(b"\x00question")
    assert os.read(master, 100) == b"\x00question"
    os.write(master, b"\x00\x11\x13\xff answer")
    time.sleep(0.05)
    assert port.read() == b"\x00\x11\x13\xff answer"
    port.close()


@pty_only
def test_a_read_without_bytes_returns_none(pty: "tuple[int, str]") -> None:
    port = open_port(pty[1])
    assert port.read() == b""
    port.close()


@pty_only
def test_an_unplugged_adapter_is_reported_in_words(pty: "tuple[int, str]") -> None:
    master, name = pty
    port = open_port(name)
    os.close(master)
    with pytest.raises(LinkLost, match="went away; check cable and board"):
        read_often(port)
    port.close()


@pty_only
def test_a_second_program_on_the_port_is_refused(pty: "tuple[int, str]") -> None:
    _, name = pty
    code = f"import serial, sys; p = serial.Serial({name!r}, exclusive=True); print('open', flush=True); sys.stdin.read()"
    other = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        assert other.stdout is not None
        assert other.stdout.readline().strip() == b"open"
        with pytest.raises(PortBusy, match="another program has this port"):
            open_port(name)
    finally:
        other.communicate(b"")


def test_a_port_that_is_not_there_is_reported_in_words() -> None:
    with pytest.raises(PortError, match=r"there is no such port|cannot be opened"):
        open_port("/dev/does-not-exist" if os.name != "nt" else "COM250")


def test_a_file_is_no_port(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("x")
    with pytest.raises(PortError):
        open_port(str(tmp_path / "file"))


@pytest.mark.parametrize(
    "name",
    ["", "a\nb", "x" * 300, "socket://", "socket://127.0.0.1:notaport", "socket://h:70000", "nonsense://x",
     "loop://", "hwgrep://.", "alt:///dev/ttyS0?class=PosixPollSerial", "file://h:1", "socket://h:1/etc/passwd",
     "socket://h:1?logging=debug", "socket://me:secret@h:1"],
)  # fmt: skip
def test_a_name_that_is_no_port_is_reported_in_words(name: str) -> None:
    with pytest.raises(PortError, match=r"is no port|no name of a port"):
        open_port(name)


@pytest.mark.parametrize("wait", ["1e3", "0", "-1", "nan", "inf", "", "5.1"])
def test_a_server_is_not_waited_for_as_long_as_a_name_says(wait: str) -> None:
    with pytest.raises(PortError, match=r"timeout must be a number of seconds, at most 5"):
        open_port(f"rfc2217://127.0.0.1:1?timeout={wait}")


@pytest.mark.parametrize(
    "name",
    [
        "COM3",
        "/dev/ttyACM0",
        "socket://[::1]:5000",
        "RFC2217://h:1?ign_set_control",
        "rfc2217://h:1?timeout=4.5",
    ],
)
def test_a_name_of_a_port_is_let_through(name: str) -> None:
    assert fault_of(name) == ""


def test_no_port_makes_or_overwrites_a_file(pty: "tuple[int, str]", tmp_path: Path) -> None:
    """pyserial's `spy://` writes what passes a port into a file of the caller's choice."""
    kept = tmp_path / "precious"
    kept.write_text("mine")
    for scheme in ("spy", "SPY", " spy"):
        for file in (kept, tmp_path / "new"):
            with pytest.raises(PortError):
                open_port(f"{scheme}://{pty[1]}?file={file}")
    assert kept.read_text() == "mine"
    assert not (tmp_path / "new").exists()


def test_a_pipe_in_place_of_a_device_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(PortError, match="no device"):
        open_port(str(tmp_path / "pipe"))


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="needs a user whom permissions bind")
def test_a_port_without_permission_is_reported_in_words(pty: "tuple[int, str]") -> None:
    os.chmod(pty[1], 0)
    with pytest.raises(PortError, match="no permission"):
        open_port(pty[1])


def test_a_refusal_of_permission_is_understood(monkeypatch: pytest.MonkeyPatch) -> None:
    """What pyserial raises on Linux, where this test may run as a user whom nothing binds."""
    import serial

    def refuse(*_: object, **__: object) -> None:
        raise serial.SerialException(13, "could not open port /dev/ttyX: [Errno 13] Permission denied")

    monkeypatch.setattr(serial, "serial_for_url", refuse)
    with pytest.raises(PortError, match="dialout"):
        open_port("/dev/ttyX")


@pytest.fixture
def listener() -> socket.socket:
    server = socket.create_server(("127.0.0.1", 0))
    server.settimeout(5)
    yield server  # type: ignore[misc]
    server.close()


def test_a_socket_is_a_port(listener: socket.socket) -> None:
    port = open_port(f"socket://127.0.0.1:{listener.getsockname()[1]}")
    side, _ = listener.accept()
    with side:
        side.sendall(bytes(range(256)) * 40)
        got = b""
        until = time.monotonic() + 5
        while len(got) < 10240 and time.monotonic() < until:
            got += port.read()
        assert got == bytes(range(256)) * 40
        port.write(b"back")
        assert side.recv(10) == b"back"
    with pytest.raises(LinkLost):
        read_often(port)
    port.close()


def test_a_socket_that_nobody_listens_on_is_reported_in_words(listener: socket.socket) -> None:
    number = listener.getsockname()[1]
    listener.close()
    with pytest.raises(PortError, match="nothing listens there"):
        open_port(f"socket://127.0.0.1:{number}")


def test_a_socket_that_takes_nothing_does_not_hold_the_station(listener: socket.socket) -> None:
    port = open_port(f"socket://127.0.0.1:{listener.getsockname()[1]}")
    side, _ = listener.accept()
    with side, pytest.raises(LinkLost):
        write_often(port)
    port.close()


def test_no_thread_stays_behind() -> None:
    assert all("reader of" not in thread.name for thread in threading.enumerate())


@pytest.mark.parametrize("name", ["/dev/ttyX", "socket://127.0.0.1:9"])
def test_bytes_that_came_before_the_cable_was_pulled_are_kept(name: str) -> None:
    class Pulled:
        """Gives four bytes (a socket: one), and is gone when it is asked for more."""

        gone = False

        @property
        def in_waiting(self) -> int:
            if self.gone:
                raise OSError(5, "Input/output error")
            return 4

        def read(self, size: int) -> bytes:
            if self.gone:
                raise OSError(5, "Input/output error")
            self.gone = True
            return b"last"[:size]

    port = SerialPort(name, Pulled())
    assert b"last".startswith(port.read() or b"?")
    with pytest.raises(LinkLost):
        port.read()
