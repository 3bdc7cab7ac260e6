"""Why samples are missing: lost on the wire, overrun in the board, lost by a reboot, or noted at an import."""

import numpy as np

from daq.recording import Gap, Mask

MOST_OVERRUNS = 20_000


class Losses:
    """What the board and the notes of an import said of missing samples; `dropped` by its DATA, in all."""

    def __init__(self) -> None:
        self.noted: list[Gap] = []
        self.dropped = 0
        self._overruns: list[tuple[int, int]] = []

    def clear(self) -> None:
        """Forget the overruns of an earlier capture."""
        self.dropped = 0
        self._overruns.clear()

    def overrun(self, first: int, stop: int) -> None:
        """Take note that the board dropped samples `first` to `stop - 1`."""
        if len(self._overruns) < MOST_OVERRUNS:
            self._overruns.append((max(first, 0), stop))

    def before(self, first: int, expected: int, dropped: int) -> tuple[Gap, ...]:
        """Return the gaps between the sample expected and the next to come, of which the board dropped some."""
        count = first - expected
        dropped = min(dropped, count)
        wire = count - dropped
        if self.noted:
            return tuple(gap for gap in self.noted if expected <= gap.first < first)
        lost = (Gap(expected, wire, "wire"), Gap(expected + wire, dropped, "overrun"))
        return tuple(gap for gap in lost if gap.count)

    def gaps(self, valid: Mask, arrived: Mask, first: int, rebooted_at: int | None) -> tuple[Gap, ...]:
        """Return the runs of invalid samples with their reasons.

        `valid` and `arrived`, shape (n,), begin at sample `first`; `rebooted_at` is the first sample that a
        reboot cost, None without one.
        """
        if valid.all():
            return ()
        reasons = np.full(len(valid), "wire", dtype=object)
        reasons[arrived] = "not a number"
        for a, b in self._overruns:
            part = slice(max(a - first, 0), max(b - first, 0))
            reasons[part][~arrived[part]] = "overrun"
        for gap in self.noted:
            reasons[max(gap.first - first, 0) : max(gap.first + gap.count - first, 0)] = gap.reason
        if rebooted_at is not None:
            reasons[max(rebooted_at - first, 0) :] = "reboot"
        reasons[valid] = None
        edges = np.flatnonzero(reasons[1:] != reasons[:-1]) + 1
        runs = zip([0, *edges.tolist()], [*edges.tolist(), len(valid)], strict=True)
        return tuple(Gap(first + a, b - a, reasons[a]) for a, b in runs if reasons[a] is not None)
