"""The flags of a recording's samples in words: how many of a channel, of which kind, and where."""

from collections.abc import Iterable
from typing import Any


def flagged_lines(flags: Iterable[dict[str, Any]], rate: float) -> list[str]:
    """Return a line for each channel and flag of runs (`channel`, `flag`, `first`, `count`) at `rate` Hz."""
    found: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for run in flags:
        found.setdefault((run["channel"], run["flag"]), []).append((run["first"], run["count"]))
    return [
        f"{channel}: {flag}, {sum(count for _, count in spans)} samples"
        f" from {spans[0][0] / rate:.3f} to {(spans[-1][0] + spans[-1][1]) / rate:.3f} s"
        for (channel, flag), spans in found.items()
    ]
