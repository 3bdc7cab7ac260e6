"""Sensors of the simulated board that break: what becomes of a ramp of codes, however it is cut into calls."""

import numpy as np
import pytest

from mocks.broken_sensors import BROKEN_SENSORS, STRIKES_S, parse_broken

RATE, LARGEST = 100.0, (1000.0, 1000.0)
STRUCK = round(STRIKES_S * RATE)
RAMP = np.stack([np.arange(-400, 600), np.arange(1000, 0, -1)], axis=1).astype(np.int32)


def read(text: str, pieces: int = 7) -> np.ndarray:
    sensor = parse_broken(text, LARGEST, 3)
    parts = np.array_split(np.arange(len(RAMP)), pieces)
    return np.concatenate([sensor.read(RAMP[part], int(part[0]), RATE) for part in parts])


@pytest.mark.parametrize("name", BROKEN_SENSORS)
def test_the_cut_into_calls_does_not_matter_and_a_channel_can_be_chosen(name: str) -> None:
    assert np.array_equal(read(name), read(name, 1))
    one = read(f"{name}::acceleration")
    assert np.array_equal(one[:, 0], RAMP[:, 0])
    assert np.array_equal(one[:, 1], read(name)[:, 1])
    assert not np.array_equal(one[:, 1], RAMP[:, 1])


def test_each_fault_is_what_it_says() -> None:
    assert (read("stuck:2")[STRUCK : STRUCK + 200] == RAMP[STRUCK - 1]).all()
    assert np.array_equal(read("stuck:2")[STRUCK + 200 :], RAMP[STRUCK + 200 :])
    assert np.array_equal(read("repeats:4")[4::4], RAMP[3:-1:4])
    assert np.array_equal(read("gain-change:2")[STRUCK:], 2 * RAMP[STRUCK:])
    assert np.array_equal(read("sign-change")[STRUCK:], -RAMP[STRUCK:])
    assert read("flat-top:0.3").max() == 300
    assert read("flat-top:0.3").min() == -300
    assert set((read("wraps:0.5") - RAMP).ravel().tolist()) == {0, -1000}
    leaps = np.abs(read("spikes:1") - RAMP)
    assert leaps.sum(axis=0).tolist() == [500, 500]


@pytest.mark.parametrize("text", ["stuck:x", "stuck:1:sideways"])
def test_what_cannot_be_understood_is_said(text: str) -> None:
    with pytest.raises(ValueError, match=text):
        parse_broken(text, LARGEST, 3)
