"""What the operator sees in the terminal while a board is being recorded."""

from typing import Self

import numpy as np
from rich.bar import Bar
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from daq.capture import CaptureObserver
from daq.recording import Array, Channel, Gap
from firmware_protocol import Hello
from station.safe_text import SafeConsole
from station.text.numbers import scale_as_recorded, typeset, typeset_unit

BAR = 28
REFRESH_HZ = 8

STATES = {
    "resting": "rest",
    "armed": "ARMED",
    "triggered": "released",
    "recording": "recording the decay",
    "resending": "lost samples",
    "holding": "rig",
    "sealed": "sealed",
}
"""What stands before the detail of each state, which says what the operator should do."""


class Watch(CaptureObserver):
    """Live levels on stderr where it is a terminal; a line for each change of state where it is not.

    All that it sees it passes on to another observer, as the live viewer.
    """

    def __init__(self, also: CaptureObserver | None = None, console: Console | None = None) -> None:
        self._also = also or CaptureObserver()
        self._console = console or SafeConsole(stderr=True, highlight=False)
        self._live = Live(console=self._console, refresh_per_second=REFRESH_HZ, transient=True)
        self._channels: tuple[Channel, ...] = ()
        self._largest = np.zeros(0)

    def __enter__(self) -> Self:
        self._live.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._live.stop()

    def connected(self, hello: Hello, channels: tuple[Channel, ...]) -> None:
        """Print which board answered and what it measures."""
        self._also.connected(hello, channels)
        self._channels = channels
        self._largest = np.zeros(len(channels))
        names = ", ".join(f"{channel.name} [{channel.unit}]" for channel in channels)
        self._line(f"board {hello.board}: {names}")

    def state(self, name: str, detail: str) -> None:
        """Print what the station is doing and what the operator should do."""
        self._also.state(name, detail)
        sentence = STATES.get(name, name)
        if detail.startswith(sentence):
            self._line(detail)
        else:
            self._line(f"{sentence}: {detail}" if detail else sentence)

    def block(self, first_index: int, samples: Array) -> None:
        """Show the newest level of each channel, and the largest so far."""
        self._also.block(first_index, samples)
        self._largest = np.maximum(self._largest, np.abs(samples).max(axis=1))
        self._live.update(self._levels(samples[:, -1]))

    def loss(self, gap: Gap) -> None:
        """Print a loss at once."""
        self._also.loss(gap)
        self._line(f"lost {gap.count} samples from number {gap.first} on: {gap.reason}")

    def _line(self, text: str) -> None:
        self._console.print(Text(typeset(text)), soft_wrap=True)

    def _levels(self, last: Array) -> Table:
        table = Table.grid(padding=(0, 2))
        for channel, value, largest in zip(self._channels, last, self._largest, strict=True):
            factor, unit = scale_as_recorded(channel.quantity, channel.unit)
            share = float(value / largest) if largest > 0.0 else 0.0
            table.add_row(
                channel.name,
                Bar(2.0, 1.0 + min(share, 0.0), 1.0 + max(share, 0.0), width=BAR, color="cyan"),
                f"{value * factor:10.3f} {typeset_unit(unit)}",
            )
        return table
