"""A file of several releases: each becomes a session, whatever the hand does between them."""

import numpy as np
import pytest

from daq.recording import Channel, Recording
from station.results.sessions import split

RATE = 50.0


def pulled_and_let_go(cycles: float) -> np.ndarray:
    """A 1 Hz mass that a hand pulls for some cycles, holds for one, and lets go for 30 s."""
    pull = 0.5 - 0.5 * np.cos(np.pi * np.arange(0.0, cycles, 1.0 / RATE) / cycles)
    time = np.arange(0.0, 30.0, 1.0 / RATE)
    free = np.exp(-0.12 * time) * np.cos(2.0 * np.pi * time)
    return np.concatenate([pull, np.ones(round(RATE)), free])


def recorded(motion: np.ndarray) -> Recording:
    noise = 1e-3 * np.random.default_rng(1).standard_normal(len(motion))
    channel = Channel(name="u", quantity="displacement", unit="m")
    return Recording(RATE, (channel,), (0.01 * (motion + noise))[None, :], np.ones(len(motion), dtype=bool))


@pytest.mark.parametrize("number", [2, 3])
@pytest.mark.parametrize("cycles", [0.5, 1.5, 4.0])
def test_each_release_is_a_session_though_the_next_pull_follows_it(number, cycles):
    motion = np.concatenate([np.zeros(round(3 * RATE)), *[pulled_and_let_go(cycles)] * number])
    pieces, _ = split(recorded(motion))
    assert len(pieces) == number
