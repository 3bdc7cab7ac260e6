"""What a command prints: one JSON object on stdout when asked, progress and errors on stderr."""

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

WIDTH = 80
#: Control characters that JSON leaves as they are, and that a terminal would obey.
ESCAPED = {code: f"\\u{code:04x}" for code in range(0x7F, 0xA0)}


def print_json(document: dict[str, Any]) -> None:
    """Print one JSON object on stdout; numbers that are not finite become null, as JSON has none."""
    from pydantic_core import to_json

    text = to_json(document, indent=2, inf_nan_mode="null").decode()
    sys.stdout.write(text.translate(ESCAPED) + "\n")
    sys.stdout.flush()


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


def say(line: str) -> None:
    """Print a line on stdout as it is, neither folded nor read as markup: what is in it can be copied."""
    screen().print(line, markup=False, soft_wrap=True)
