"""Warnings and log entries of libraries: each becomes one harmless line, without paths and tracebacks."""

import logging
import warnings
from collections.abc import Callable
from typing import Any

from station.output import progress

LONGEST = 300


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


def say_in_one_line(say: Callable[[str], None] = progress) -> None:
    """From now on let this process say warnings and log entries so."""

    def show(message: Warning | str, category: type[Warning], *_: Any, **__: Any) -> None:
        if issubclass(category, RuntimeWarning):  # of arithmetic: what comes of it is judged where it is used
            return
        say(f"{category.__name__}: {' '.join(str(message).split())[:LONGEST]}")

    warnings.showwarning = show
    logging.basicConfig(handlers=[OneLine(say)], level=logging.WARNING, force=True)
