"""Conversations with boards that lie: what differs from what a board sampled is never OK, nothing hangs.

`python -m bench lies` holds thousands of them. A seed is a board; the lies are drawn by `mocks.lies` and
`mocks.lying_board`, the truth is what that board had at its input.
"""

from pathlib import Path
from unittest import mock

import pytest
from lying_conversation import LIMIT_S, SETTINGS, converse

from daq.clock_check import CheckedRate
from mocks.lies import KINDS
from mocks.lying_board import BEHAVIOURS, LyingBoard

DANGEROUS = (40, 76, 114, 120, 128, 154)  # what a station that checks less calls OK
MOST_BYTES = SETTINGS.log_bytes(256.0, 16)
READ_AT_ONCE = 1 << 16


def broken(seeds: range | tuple[int, ...], folder: Path) -> list[str]:
    """Return the promises that were broken in the conversations of these seeds."""
    found = []
    for seed in seeds:
        told = converse(seed, folder / str(seed))
        if told.wrong:
            found.append(f"called OK: {told.wrong}; {told.lies}")
        if told.elapsed_s > LIMIT_S + 2.0:
            found.append(f"{told.elapsed_s:.1f} s and not {LIMIT_S:g}; {told.lies}")
        if told.log_bytes > MOST_BYTES + READ_AT_ONCE:
            found.append(f"a log of {told.log_bytes} bytes; {told.lies}")
    return found


def test_no_lie_passes_for_a_good_recording(tmp_path: Path) -> None:
    assert broken((*range(60), *DANGEROUS), tmp_path) == []


def test_an_honest_board_among_them_is_ok(tmp_path: Path) -> None:
    plans = {seed: LyingBoard(seed).plan for seed in range(60)}
    honest = [seed for seed, plan in plans.items() if not plan.kinds and not plan.behaviours][:2]
    assert [converse(seed, tmp_path / str(seed)).verdict for seed in honest] == ["OK", "OK"]


@pytest.mark.parametrize(
    ("left_out", "seed", "nothing"), [("integrity", 40, ()), ("checked_rate", 76, CheckedRate(0.0))]
)
def test_a_station_that_checks_less_is_caught(
    tmp_path: Path, left_out: str, seed: int, nothing: object
) -> None:
    with mock.patch(f"daq.quality.{left_out}", return_value=nothing):
        assert "wrong" in converse(seed, tmp_path / "s").wrong


def test_every_lie_is_told_by_some_board() -> None:
    plans = [LyingBoard(seed).plan for seed in range(200)]
    assert {kind for plan in plans for kind in plan.kinds} == set(KINDS)
    assert {behaviour for plan in plans for behaviour in plan.behaviours} == set(BEHAVIOURS)
