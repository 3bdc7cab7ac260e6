"""What a command prints: one JSON object on stdout when asked, progress and errors on stderr."""

import logging
import shlex
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

WIDTH = 80
TYPED = "typed"
"""Under which the context of a command keeps the words that were typed."""

LONGEST = 300
"""Letters of a warning, or of a log entry, of a library: each becomes one harmless line, without paths and tracebacks."""

#: Control characters that JSON leaves as they are, and that a terminal would obey.
ESCAPED = {code: f"\\u{code:04x}" for code in range(0x7F, 0xA0)}


def print_json(document: dict[str, Any]) -> None:
    """Print one JSON object on stdout; numbers that are not finite become null, as JSON has none."""
    from pydantic_core import to_json

    text = to_json(document, indent=2, inf_nan_mode="null").decode()
    sys.stdout.write(text.translate(ESCAPED) + "\n")
    sys.stdout.flush()


def asked_for_json() -> bool:
    """Tell whether the command under way prints one JSON object instead of words."""
    return bool(click.get_current_context().params["as_json"])


def progress(text: str) -> None:
    """Print on stderr what is going on, in one line whatever names it holds."""
    from station.safe_text import harmless

    click.echo(harmless(text).replace("\n", "\N{REPLACEMENT CHARACTER}"), err=True)


def screen() -> "Console":
    """Return the console on stdout: 80 columns unless the terminal says otherwise."""
    from station.safe_text import SafeConsole

    console = SafeConsole(highlight=False)
    return console if console.is_terminal else SafeConsole(highlight=False, width=WIDTH)


def command_line(*words: str | Path) -> str:
    """Return a command of the station as it is typed: `station` and the words, quoted where a shell would part them."""
    return f"station {shlex.join(str(word) for word in words)}"


def next_line(*words: str | Path) -> str:
    """Return the last line of a command's output, which says what to run next."""
    return f" next: {command_line(*words)}"


class OneLine(logging.Handler):
    """Says a log entry in one line, whatever traceback comes with it."""

    def __init__(self, say: Callable[[str], None]) -> None:
        super().__init__()
        self._say = say

    def emit(self, record: logging.LogRecord) -> None:
        """Say it."""
        error = record.exc_info[1] if record.exc_info else None
        words = " ".join(record.getMessage().split())
        kind = "" if error is None or type(error).__name__ in words else f"{type(error).__name__}: "
        self._say(f"{record.name}: {kind}{words[:LONGEST]}")


def say_in_one_line() -> None:
    """From now on let this process say warnings and log entries so."""

    def show(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
        if issubclass(category, RuntimeWarning):  # of arithmetic: what comes of it is judged where it is used
            return
        progress(f"{category.__name__}: {' '.join(str(message).split())[:LONGEST]}")

    warnings.showwarning = show
    logging.basicConfig(handlers=[OneLine(progress)], level=logging.WARNING, force=True)
