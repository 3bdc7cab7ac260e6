"""A cable that can be harmed: bytes pass between a TCP port and a board, some are lost, or it is pulled."""

import contextlib
import socket
import threading
import time
from collections.abc import Callable

from firmware_protocol import Decoder, Start


class Relay:
    """Serve one host at a time on a free TCP port; what it sends goes to the board's port and back.

    `at` seconds after the host's START, `then` is called, once.
    """

    def __init__(
        self, board_port: int, at: float = 0.0, then: Callable[["Relay"], None] | None = None
    ) -> None:
        self.board_port, self.at, self.then = board_port, at, then
        self.to_lose = 0
        self._decoder = Decoder()
        self._closing = threading.Event()
        self._server = socket.create_server(("127.0.0.1", 0))
        self._open: list[socket.socket] = [self._server]
        self.address = f"socket://127.0.0.1:{self._server.getsockname()[1]}"
        self._threads = [threading.Thread(target=self._serve)]
        self._threads[0].start()

    def close(self) -> None:
        """Pull the cable."""
        self._closing.set()
        for one in self._open:
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)
            one.close()

    def join(self) -> None:
        for thread in self._threads:
            thread.join(10)

    def _serve(self) -> None:
        while not self._closing.is_set():
            with contextlib.suppress(OSError):
                host, _ = self._server.accept()
                board = socket.create_connection(("127.0.0.1", self.board_port), timeout=5)
                board.settimeout(None)
                self._open += [host, board]
                back = threading.Thread(target=self._pass_on, args=(board, host, self._harmed))
                self._threads.append(back)
                back.start()
                self._pass_on(host, board, self._watched)

    def _pass_on(self, source: socket.socket, to: socket.socket, through: Callable[[bytes], bytes]) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(4096):
                to.sendall(through(data))
        for one in (source, to):
            with contextlib.suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def _harmed(self, data: bytes) -> bytes:
        lost = min(self.to_lose, len(data))
        self.to_lose -= lost
        return data[lost:]

    def _watched(self, data: bytes) -> bytes:
        started = any(isinstance(frame.message, Start) for frame in self._decoder.feed(data))
        if started and self.then is not None:
            threading.Thread(target=self._harm, args=(self.then,)).start()
            self.then = None
        return data

    def _harm(self, then: Callable[["Relay"], None]) -> None:
        time.sleep(self.at)
        then(self)
