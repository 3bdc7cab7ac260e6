"""Every fault of docs/faults.md, injected into a real line, ends as the page promises."""

import os
from pathlib import Path

import pytest
from fault_bench import INJECTED, REAL_TIME, Promise, broken_promises, inject, promises

from mocks.broken_sensors import BROKEN_SENSORS
from mocks.faults import NAMES
from mocks.misconfigurations import MISCONFIGURATIONS

ROWS = promises()
# Each row on one line, in turn, every other row only with the slow tests; on both where the line itself is at fault. `python
# -m bench trust` injects every row on each of its lines, in real time and with several seeds, and alone those that are of
# the same kind as flipped bits, lost frames and a bumped table.
ON_BOTH = ("unplug", "unplug and replug")
OF_THE_SAME_KIND = (
    "lost bytes",
    "inserted bytes",
    "duplicated bytes",
    "reordered bytes",
    "a frame cut",
    "a frame twice",
)
LONG = (
    "a slow line",
    "a second program on the socket",
    "no description",
    "line noise",
    "a resend without end",
)
CASES = [
    pytest.param(
        row,
        line,
        id=f"{row.fault} on {line}",
        marks=[pytest.mark.slow] if number % 2 or row.fault in LONG or REAL_TIME in row.injected else [],
    )
    for number, row in enumerate(ROWS)
    if row.fault not in OF_THE_SAME_KIND
    for line in (row.lines if row.fault in ON_BOTH else (row.lines[number % len(row.lines)],))
]
# Sixteen times as fast as life a capture of 3 s takes half a second; what takes longer is the wait
# of the fault itself.
SPEED = 16.0

pytestmark = pytest.mark.usefixtures("unrendered")


@pytest.mark.parametrize(("promise", "line"), CASES)
def test_a_fault_ends_as_the_page_promises(tmp_path: Path, promise: Promise, line: str) -> None:
    if line == "pty" and os.name == "nt":
        pytest.skip("this system has no pty")
    outcome = inject(promise, line, tmp_path, SPEED, 5, "--duration", "3")
    assert not broken_promises(promise, outcome), outcome.said


def test_the_page_promises_something_of_every_fault_that_the_double_knows() -> None:
    injected = " ".join(row.injected for row in ROWS)
    assert [name for name in (*NAMES, *MISCONFIGURATIONS, *BROKEN_SENSORS) if name not in injected] == []
    assert sorted(INJECTED) == sorted(row.fault for row in ROWS)


def test_a_broken_promise_is_noticed(tmp_path: Path) -> None:
    """The harness can fail: a sound board held to the promise of a reversed sensor breaks it."""
    sound = next(row for row in ROWS if row.fault == "none")
    reversed_sign = next(row for row in ROWS if row.fault == "sign reversed")
    outcome = inject(sound, "tcp", tmp_path, SPEED, 5, "--duration", "3")
    assert len(broken_promises(reversed_sign, outcome)) == 3
