"""The bench's double in a thread of the calling program, on a real line: a process of its own costs seconds."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from mocks.cli import open_link, parse
from mocks.serve import serve
from mocks.simulated_board import SimulatedBoard


@contextmanager
def running(*arguments: str) -> Iterator[str]:
    """Run the double with the arguments of `python -m mocks`; yield the address of its line.

    ValueError for what cannot be simulated; SystemExit for a wrong command line.
    """
    options = parse(arguments)
    simulated = SimulatedBoard(options)
    link = open_link(options)
    over = threading.Event()
    thread = threading.Thread(
        target=serve,
        args=(link, simulated.board, simulated.line, options.speed, options.once, over.is_set),
        name="bench double",
        daemon=True,
    )
    try:
        simulated.write_truth()
        thread.start()
        yield link.address
    finally:
        over.set()
        if thread.ident is not None:
            thread.join(timeout=5.0)
        link.close()
