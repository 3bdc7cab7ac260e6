"""The command that comes next, as it can be typed."""

import shlex
from pathlib import Path


def command_line(*words: str | Path) -> str:
    """Return a command of the station as it is typed: `station` and the words, quoted where a shell would part them."""
    return f"station {shlex.join(str(word) for word in words)}"


def next_line(*words: str | Path) -> str:
    """Return the last line of a command's output, which says what to run next."""
    return f" next: {command_line(*words)}"
