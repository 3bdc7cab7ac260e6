"""The serial port behind four words: name, read, write, close. The only module that imports pyserial."""

import contextlib
import errno
import os
import sys
import time
from dataclasses import dataclass
from typing import Any, Protocol

import serial
from serial.tools import list_ports as serial_list

from daq.errors import LinkLost, PortBusy, PortError
from daq.port_names import require_port

BAUD = 115200
GONE = (serial.SerialException, OSError, TypeError, AttributeError)
READ_TIMEOUT_S = 0.05
WRITE_TIMEOUT_S = 1.0
REOPEN_S = 5.0
BIGGEST_READ = 1 << 16


class Port(Protocol):
    """Bytes in and out. `read` waits at most about 50 ms and returns what there is, perhaps nothing.

    `read` and `write` raise LinkLost when the other side is gone.
    """

    name: str

    def read(self) -> bytes:
        """Return the bytes that are there; b"" when none came within about 50 ms."""

    def write(self, data: bytes) -> None:
        """Send all of `data` or raise LinkLost."""

    def close(self) -> None:
        """Give the port back; harmless when done twice."""


@dataclass(frozen=True)
class PortDescription:
    """A port that the system knows: its name, and what hangs on it."""

    name: str
    description: str = ""


def system_ports() -> tuple[PortDescription, ...]:
    """Return the serial ports of this computer, adapters on USB first."""
    ports = sorted(serial_list.comports(), key=lambda p: (p.vid is None, p.device))
    return tuple(PortDescription(p.device, _plain(p.description)) for p in ports)


def _plain(text: str | None) -> str:
    return "" if text in (None, "n/a") else str(text)


def open_port(name: str, baud: int = BAUD) -> Port:
    """Open a device, `socket://HOST:PORT` or `rfc2217://HOST:PORT` for this program alone.

    PortBusy when another program has it; PortError for any other name, when it is not there, and without permission.
    """
    require_port(name)
    until = time.monotonic() + (REOPEN_S if sys.platform == "win32" else 0.0)
    while True:
        try:
            return SerialPort(name, _open(name, baud))
        except PortBusy:
            if time.monotonic() > until:
                raise
            time.sleep(0.2)


def may_have_reset_the_board(port: Port) -> bool:
    """Check whether opening the port may have made the board boot, as a real serial line does with Arduinos."""
    return isinstance(port, SerialPort) and port.has_modem_lines()


def _open(name: str, baud: int) -> Any:
    try:
        device = serial.serial_for_url(name, do_not_open=True)
        device.baudrate = baud
        device.timeout = READ_TIMEOUT_S
        device.write_timeout = WRITE_TIMEOUT_S
        if "://" not in name:
            device.exclusive = True
        device.open()
    except (serial.SerialException, OSError, ValueError) as error:
        raise _why(name, error) from error
    return device


def _why(name: str, error: Exception) -> PortError:
    code = getattr(error, "errno", None)
    text = str(error).lower()
    taken = code in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text or "busy" in text
    if taken or (sys.platform == "win32" and "permissionerror" in text):
        return PortBusy(f"{name}: another program has this port; close it and try again")
    if code in (errno.EACCES, errno.EPERM) or "permission" in text:
        return PortError(
            f"{name}: you have no permission to open this port; join its group"
            " (`sudo usermod -aG dialout $USER`, then log in again)"
        )
    if (
        code in (errno.ENOENT, errno.ENXIO, errno.ENODEV)
        or "no such file" in text
        or "could not find" in text
    ):
        return PortError(f"{name}: there is no such port; plug the board in or list the ports")
    if name.startswith("socket://"):
        return PortError(f"{name}: nothing listens there; start the board or correct the address")
    return PortError(f"{name}: cannot be opened as a port ({error})")


class SerialPort:
    """A port by pyserial."""

    def __init__(self, name: str, device: Any) -> None:
        self.name = name
        self._device = device
        self._is_socket = name.startswith("socket://")

    def read(self) -> bytes:
        """Return the bytes that are there; b"" when none came within about 50 ms.

        Bytes that came before the port went away are returned; the next call raises LinkLost.
        """
        try:
            data = bytes(self._device.read(1 if self._is_socket else self._waiting() or 1))
        except GONE as error:
            raise self._gone(error) from error
        with contextlib.suppress(*GONE):
            return data + self._rest() if data else data
        return data

    def write(self, data: bytes) -> None:
        """Send all of `data` or raise LinkLost."""
        try:
            self._device.write(data)
        except serial.SerialTimeoutException as error:
            raise LinkLost(f"{self.name} took no bytes for {WRITE_TIMEOUT_S:g} s; check the cable") from error
        except GONE as error:
            raise self._gone(error) from error

    def has_modem_lines(self) -> bool:
        """Check whether there is a real serial line behind it: a pseudo-terminal or a network has none to ask for."""
        with contextlib.suppress(*GONE):
            return "://" not in self.name and self._device.dsr is not None
        return False

    def close(self) -> None:
        """Give the port back; harmless when done twice."""
        handle = getattr(self._device, "_socket", None)
        with contextlib.suppress(serial.SerialException, OSError):
            self._device.close()
        if handle is not None:
            handle.close()

    def _rest(self) -> bytes:
        return self._drain_socket() if self._is_socket else bytes(self._device.read(self._waiting()))

    def _waiting(self) -> int:
        return min(int(self._device.in_waiting), BIGGEST_READ)

    def _drain_socket(self) -> bytes:
        """Take what else a socket holds; pyserial's `in_waiting` says only whether there is something."""
        handle = getattr(self._device, "_socket", None)
        if handle is None or not self._device.in_waiting:
            return b""
        with contextlib.suppress(BlockingIOError):
            return bytes(handle.recv(BIGGEST_READ))
        return b""

    def _gone(self, error: Exception) -> LinkLost:
        return LinkLost(f"{self.name} went away; check cable and board ({_reason(error)})")


def _reason(error: Exception) -> str:
    code = getattr(error, "errno", None)
    if "returned no data" in str(error):
        return "unplugged, or another program reads it"
    return os.strerror(code) if isinstance(code, int) else str(error).splitlines()[0][:60] or "closed"
