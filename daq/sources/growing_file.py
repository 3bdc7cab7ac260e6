"""A file that another program writes to, as a port: what is added from now on."""

import os
import time
from pathlib import Path

from daq.errors import LinkLost, PortError

WAIT_S = 0.03
BIGGEST_READ = 1 << 16


class GrowingFile:
    """A port (see `daq.port.Port`) that gives what is added to a file after it was opened."""

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        try:
            self._file = path.open("rb", buffering=0)
        except FileNotFoundError as error:
            raise PortError(f"{path}: there is no such file") from error
        except OSError as error:
            raise PortError(f"{path}: cannot be read ({error.strerror or error})") from error
        self._file.seek(0, os.SEEK_END)

    def read(self) -> bytes:
        """Return the bytes added since; b"" for none. Raises LinkLost where the file became shorter."""
        data = self._file.read(BIGGEST_READ) or b""
        if not data:
            if os.fstat(self._file.fileno()).st_size < self._file.tell():
                raise LinkLost(
                    f"{self.name}: the file was cut off while it was read; what came before is kept"
                )
            time.sleep(WAIT_S)
        return data

    def write(self, data: bytes) -> None:
        """Do nothing: a file is only read."""

    def close(self) -> None:
        """Close the file."""
        self._file.close()
