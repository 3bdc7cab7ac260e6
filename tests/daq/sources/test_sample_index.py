"""Indices of lines: lost ones are seen, counters wrap, stamps in whole milliseconds are no jitter."""

import numpy as np
import pytest

from daq.errors import BoardError, LinkLost
from daq.sources.line_source import CountedIndex, StampedIndex


@pytest.mark.parametrize("wrap", [256, 65536, 1 << 32])
def test_a_counter_begins_anew_after_its_bits(wrap):
    counted = CountedIndex()
    first = wrap - 5
    assert [counted.next((first + i) % wrap) for i in range(0, 20, 2)] == list(range(0, 20, 2))


def test_a_counter_that_goes_back_is_a_reboot():
    counted = CountedIndex()
    counted.next(100)
    with pytest.raises(LinkLost, match="from 100 to 3"):
        counted.next(3)


def test_a_column_that_is_no_counter_is_refused():
    counted = CountedIndex()
    counted.next(0)
    with pytest.raises(BoardError, match="is that column a counter"):
        counted.next(5e7)


@pytest.mark.parametrize("rate", [256.0, 100.0, 487.3])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_stamps_in_whole_milliseconds_with_jitter_lose_nothing(rate, seed):
    random = np.random.default_rng(seed)
    n = np.arange(4000)
    stamps = np.floor(1000 * (n / rate + random.uniform(0, 0.2 / rate, len(n)))) / 1000
    stamped = StampedIndex(rate * 1.0001, wrap_s=4294967.296)
    assert [stamped.next(t)[0] for t in stamps] == n.tolist()


@pytest.mark.parametrize("lost", [1, 2, 17])
def test_lost_lines_are_counted_from_stamps(lost):
    stamped = StampedIndex(256.0, wrap_s=4294967.296)
    kept = [i for i in range(600) if not 300 <= i < 300 + lost]
    assert [stamped.next(np.floor(1000 * i / 256) / 1000)[0] for i in kept] == kept


def test_stamps_in_microseconds_wrap_after_32_bits():
    wrap = 2**32 * 1e-6
    stamped = StampedIndex(256.0, wrap)
    first = wrap - 0.5
    for i in range(300):
        assert stamped.next((first + i / 256) % wrap)[0] == i


def test_stamps_that_go_back_are_a_reboot():
    stamped = StampedIndex(256.0, wrap_s=4294967.296)
    stamped.next(100.0)
    with pytest.raises(LinkLost):
        stamped.next(0.1)
