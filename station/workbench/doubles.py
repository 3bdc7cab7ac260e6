"""The bench's doubles that run on this computer: each leaves a note with its port, which is read here.

The notes lie where every user may make a folder of any name: only a folder of this user's, into which nobody else may
write, is believed.
"""

import contextlib
import getpass
import os
import re
import stat
import tempfile
from pathlib import Path

PORT = re.compile(r"socket://(127\.0\.0\.1|localhost):\d{1,5}|/dev/(pts/\d+|ttys\d+)")
"""What a double's port looks like: nothing else is believed of a file in a folder that others can write to."""

MOST = 8


def doubles() -> list[str]:
    """Return the ports at which a double may answer, the newest first."""
    try:
        folder = Path(tempfile.gettempdir()) / f"free-decay-doubles-{getpass.getuser()}"
        if not _is_own(folder):
            return []
        notes = [note for note in folder.iterdir() if note.suffix == ".port" and not note.is_symlink()]
    except (OSError, KeyError):
        return []
    found = []
    for note in sorted(notes, key=lambda n: n.name, reverse=True)[:MOST]:
        with contextlib.suppress(OSError, ValueError):
            port = note.read_text(encoding="utf-8")[:100].strip()
            if PORT.fullmatch(port):
                found.append(port)
    return found


def _is_own(folder: Path) -> bool:
    found = folder.lstat()
    if not hasattr(os, "geteuid"):  # Windows: the folder of temporary files is the user's
        return stat.S_ISDIR(found.st_mode)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.geteuid() and not found.st_mode & 0o022
