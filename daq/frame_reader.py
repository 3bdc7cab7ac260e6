"""The thread behind a link: it reads, writes the bytes to the raw log, cuts them into frames and queues these."""

import queue
import threading

from daq.errors import BoardError, LinkLost, StationError
from daq.port import Port
from daq.raw_log import Kind, RawLog
from firmware_protocol import Decoder, Frame, Statistics

MOST_BYTES = 1 << 22


class FrameReader:
    """Frames from a port with the host's times of their arrival, in order; `close` ends the thread.

    Reading ends when the log has grown by `most_bytes`: what is still to be had then is refused in `take`.
    """

    def __init__(self, port: Port, log: RawLog) -> None:
        self.most_bytes = MOST_BYTES
        self._begun = log.size
        self._port = port
        self._log = log
        self._decoder = Decoder()
        self._queue: queue.SimpleQueue[tuple[float, Frame] | StationError] = queue.SimpleQueue()
        self._failure: StationError | None = None
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._read, name=f"reader of {port.name}", daemon=True)
        self._start()

    def _start(self) -> None:
        self._thread.start()

    @property
    def statistics(self) -> Statistics:
        """What the decoder counted."""
        return self._decoder.statistics

    def take(self, timeout: float) -> tuple[float, Frame] | None:
        """Return the next frame and its time (s); None when none came within `timeout` s.

        Raises LinkLost once everything that came before it was taken.
        """
        if self._failure is not None:
            raise self._failure
        try:
            item = self._queue.get(timeout=timeout) if timeout > 0 else self._queue.get_nowait()
        except queue.Empty:
            return None
        if isinstance(item, StationError):
            self._failure = item
            raise item
        return item

    def close(self) -> None:
        """Stop reading."""
        self._stopping.set()
        self._thread.join(timeout=2.0)

    def _read(self) -> None:
        try:
            while not self._stopping.is_set():
                self.read_once()
        except StationError as error:
            self._queue.put(error)
        except Exception as error:
            self._queue.put(LinkLost(f"{self._port.name} cannot be read any more ({error})"))

    def read_once(self) -> int:
        """Take what the port has, log it and queue its frames; return how many bytes it was."""
        data = self._port.read()
        if data:
            when = self._log.append(Kind.RECEIVED, data)
            for frame in self._decoder.feed(data):
                self._queue.put((when, frame))
            if self._log.size - self._begun > self.most_bytes:
                raise BoardError(
                    f"{self._port.name}: more than {self.most_bytes / 1e6:.0f} MB came, more than the request can"
                    " need; check baud rate and port, or the board's firmware"
                )
        return len(data)
