"""Every fault of docs/faults.md, injected into a real line, ends as the page promises."""

import os
from pathlib import Path

import pytest
from fault_bench import Promise, broken_promises, inject, promises, silence

from mocks.faults import NAMES
from mocks.misconfigurations import MISCONFIGURATIONS

ROWS = promises()
CASES = [pytest.param(row, line, id=f"{row.fault} on {line}") for row in ROWS for line in row.lines]
# Sixteen times as fast as life a capture of 3 s takes half a second; what takes longer is the wait
# of the fault itself.
SPEED = 16.0
NO_PTY = pytest.mark.skipif(os.name == "nt", reason="this system has no pty")


@pytest.mark.parametrize(("promise", "line"), CASES)
def test_a_fault_ends_as_the_page_promises(tmp_path: Path, promise: Promise, line: str) -> None:
    if line == "pty" and os.name == "nt":
        pytest.skip("this system has no pty")
    outcome = inject(promise, line, tmp_path, SPEED, 5, "--duration", "3")
    assert not broken_promises(promise, outcome), outcome.said


def test_the_page_promises_something_of_every_fault_that_the_double_knows() -> None:
    injected = " ".join(row.injected for row in ROWS)
    assert [name for name in (*NAMES, *MISCONFIGURATIONS) if name not in injected] == []


def test_a_broken_promise_is_noticed(tmp_path: Path) -> None:
    """The harness can fail: a sound board held to the promise of a reversed sensor breaks it."""
    sound = next(row for row in ROWS if row.fault == "none")
    reversed_sign = next(row for row in ROWS if row.fault == "sign reversed")
    outcome = inject(sound, "tcp", tmp_path, SPEED, 5, "--duration", "3")
    assert len(broken_promises(reversed_sign, outcome)) == 3


@pytest.mark.parametrize("line", [pytest.param("pty", marks=NO_PTY), "tcp"])
def test_in_real_time_a_stalled_board_is_told_within_two_seconds_and_given_up_soon_after(
    tmp_path: Path, line: str
) -> None:
    told, given_up = silence(line, tmp_path)
    assert 0.4 < told < 2.0
    # Given up after 2 s; the rest is what a busy computer takes to close the session with its syncs.
    assert given_up < 4.0
