"""The board's end of the line: a pseudo terminal or a TCP socket, one host after another."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import sys
import time
from typing import Protocol

CHUNK = 4096


class Link(Protocol):
    """One line to one host at a time. Nothing here blocks but `wait`."""

    address: str
    reusable: bool  # Whether another host can come after the cable was pulled.

    def wait(self, seconds: float) -> None:
        """Return when bytes have come or the time is over."""

    def connected(self) -> bool:
        """Whether a host has the line open (looks; takes the next host in)."""

    def read(self) -> bytes:
        """Read the bytes that have come, b"" for none."""

    def write(self, data: bytes) -> int:
        """Send what the line takes at once and return how many bytes that was."""

    def untaken(self) -> int:
        """Bytes that the host is known not to have taken yet; 0 when the line does not say."""

    def unplug(self) -> None:
        """Break the line as a pulled cable does. A TCP line can be taken up again."""

    def close(self) -> None:
        """Give everything back."""


class TcpLink:
    """A listening socket on this machine."""

    def __init__(self, port: int = 0) -> None:
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.setblocking(False)
        self._host: socket.socket | None = None
        self.address = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        self.reusable = True

    def wait(self, seconds: float) -> None:
        """Return when bytes or a host have come, or the time is over."""
        select.select([self._host or self._listener], [], [], seconds)

    def connected(self) -> bool:
        """Take the next host in when there is none."""
        if self._host is None:
            with contextlib.suppress(BlockingIOError):
                self._host, _ = self._listener.accept()
                self._host.setblocking(False)
                self._host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self._host.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, CHUNK)
        return self._host is not None

    def read(self) -> bytes:
        """Read the bytes that have come."""
        if self._host is None:
            return b""
        try:
            data = self._host.recv(CHUNK)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if not data:
            self._drop()
        return data

    def write(self, data: bytes) -> int:
        """Send what the socket takes."""
        if self._host is None:
            return 0
        try:
            return self._host.send(data)
        except BlockingIOError:
            return 0
        except OSError:
            self._drop()
            return 0

    def untaken(self) -> int:
        """A socket does not say what the host's side still holds."""
        return 0

    def unplug(self) -> None:
        """Reset the connection."""
        if self._host is not None:
            linger = (1).to_bytes(4, sys.byteorder) + bytes(4)
            self._host.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
        self._drop()

    def close(self) -> None:
        """Close both sockets."""
        self._drop()
        self._listener.close()

    def _drop(self) -> None:
        if self._host is not None:
            self._host.close()
            self._host = None


class PtyLink:
    """A pseudo terminal: what looks most like a serial port (not on Windows)."""

    def __init__(self) -> None:
        if sys.platform == "win32":
            raise OSError("there are no pseudo terminals on Windows; use --tcp 0")
        import tty

        self._master, slave = os.openpty()
        tty.setraw(slave)
        self.address = os.ttyname(slave)
        os.close(slave)
        os.set_blocking(self._master, False)
        self._open = True
        self.reusable = False

    def wait(self, seconds: float) -> None:
        """Return when bytes have come or the time is over."""
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        events = poll.poll(seconds * 1e3)
        if events and events[0][1] & select.POLLHUP and not events[0][1] & select.POLLIN:
            time.sleep(seconds)  # Nobody has it open: poll returns at once.

    def connected(self) -> bool:
        """Whether a host has the terminal open."""
        if not self._open:
            return False
        poll = select.poll()
        poll.register(self._master, select.POLLIN)
        return not any(event & select.POLLHUP for _, event in poll.poll(0))

    def read(self) -> bytes:
        """Read the bytes that have come; a closed other side reads as nothing."""
        if not self._open:
            return b""
        try:
            return os.read(self._master, CHUNK)
        except OSError:
            return b""

    def write(self, data: bytes) -> int:
        """Send what the kernel takes (some 20 KB until the host reads)."""
        if not self._open:
            return 0
        try:
            return os.write(self._master, data)
        except OSError:
            return 0

    def untaken(self) -> int:
        """Bytes in the host's side of the terminal."""
        import fcntl
        import termios

        try:
            slave = os.open(self.address, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        except OSError:
            return 0
        try:
            waiting = fcntl.ioctl(slave, termios.FIONREAD, bytes(4))
        finally:
            os.close(slave)
        return int.from_bytes(waiting, sys.byteorder)

    def unplug(self) -> None:
        """Close the terminal: the host sees the very error of a pulled adapter."""
        self.close()

    def close(self) -> None:
        """Close the terminal."""
        if self._open:
            os.close(self._master)
            self._open = False
