"""Where a running double says at which port it is, so that a program can find it without being told."""

from __future__ import annotations

import contextlib
import getpass
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path


def folder() -> Path:
    """Return the user's folder of notes: one file for each double that runs, its port in it."""
    return Path(tempfile.gettempdir()) / f"free-decay-doubles-{getpass.getuser()}"


@contextlib.contextmanager
def announced(address: str) -> Iterator[None]:
    """Leave a note with the port while the double runs; without one where no file can be written."""
    note = folder() / f"{os.getpid()}.port"
    with contextlib.suppress(OSError, KeyError):
        note.parent.mkdir(mode=0o700, exist_ok=True)
        if hasattr(os, "geteuid") and note.parent.lstat().st_uid != os.geteuid():
            raise OSError(f"{note.parent} is another user's")
        note.write_text(f"{address}\n", encoding="utf-8")
    try:
        yield
    finally:
        with contextlib.suppress(OSError):
            note.unlink(missing_ok=True)
