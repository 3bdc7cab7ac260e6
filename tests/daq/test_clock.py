"""The rate by stamps and by arrivals, and how even they are; the truth is in closed form."""

import numpy as np
import pytest

from daq.clock import fit_arrivals, lasting_step, unevenness

RATE, N = 256.0, 16
STOPS = np.arange(N, 12 * 256 + 1, N)


def prompt(random: np.random.Generator, rate: float = RATE) -> np.ndarray:
    """When frames reach a computer that looks every 5 ms, s."""
    return STOPS / rate + random.exponential(1e-3, len(STOPS)) + random.uniform(0.0, 5e-3, len(STOPS))


def held(times: np.ndarray, until: np.ndarray) -> np.ndarray:
    """When they arrive on a line that delivers at the instants `until` only, s."""
    return until[np.searchsorted(until, times)]


def pulls(rate: float, seeds: range, hold: tuple[float, float] | None) -> list[float]:
    """How many standard errors the rate by arrivals is off, for lines that hold frames for a time drawn from `hold`."""
    found = []
    for seed in seeds:
        random = np.random.default_rng(seed)
        times = prompt(random, rate)
        if hold is not None:
            times = held(times, np.cumsum(random.uniform(*hold, 1000)))
        fit = fit_arrivals(STOPS.tolist(), times.tolist())
        assert fit is not None
        found.append((fit.rate - rate) / fit.std)
    return found


@pytest.mark.parametrize("hold", [None, (0.1, 0.1), (0.3, 0.3), (0.1, 0.8), (0.7, 0.9)])
@pytest.mark.parametrize("rate", [256.0, 240.63])
def test_the_rate_by_arrivals_is_off_by_what_its_error_says(rate, hold) -> None:
    # the error counts the scatter twice, so 3 of them are never reached by chance
    assert max(abs(pull) for pull in pulls(rate, range(40), hold)) < 3.0


def test_a_quiet_line_tells_the_rate_to_100_ppm_and_one_that_holds_for_0p8_s_to_1_percent() -> None:
    random = np.random.default_rng(1)
    quiet = fit_arrivals(STOPS.tolist(), prompt(random).tolist())
    bursts = fit_arrivals(STOPS.tolist(), held(prompt(random), np.arange(1, 30) * 0.8).tolist())
    assert quiet is not None
    assert quiet.std < 1.5e-4 * RATE
    assert bursts is not None
    assert 1e-3 * RATE < bursts.std < 1e-2 * RATE


def test_fewer_than_8_bursts_tell_no_rate() -> None:
    times = held(prompt(np.random.default_rng(1)), np.arange(1, 20) * 1.8)
    assert fit_arrivals(STOPS.tolist(), times.tolist()) is None


@pytest.mark.parametrize("pause", [0.018, 0.03, -0.03])
def test_a_pause_is_seen_in_the_arrivals(pause: float) -> None:
    times = prompt(np.random.default_rng(2)) + pause * (STOPS > 5 * 256)
    found = lasting_step(STOPS.tolist(), times.tolist())
    assert found is not None
    assert found.step == pytest.approx(pause, abs=4e-3)  # what the computer's 5 ms leave
    assert found.after <= 5 * 256 < found.index


@pytest.mark.parametrize("hold", [None, (0.1, 0.1), (0.066, 0.066), (0.1, 0.8)])
def test_neither_a_stall_nor_bursts_are_a_step(hold) -> None:
    for seed in range(30):
        random = np.random.default_rng(seed)
        times = prompt(random)
        times = np.where((times > 4.0) & (times < 5.3), 5.3, times)
        if hold is not None:
            times = held(times, np.cumsum(random.uniform(*hold, 1000)))
        assert lasting_step(STOPS.tolist(), times.tolist()) is None, seed


def stamps(late: np.ndarray, unit_us: int = 1, index: np.ndarray = STOPS, rate: float = RATE) -> list[int]:
    """Stamps of samples `index`, `late` s beside even times, in whole units."""
    return [int(t // unit_us) * unit_us for t in (index / rate + late) * 1e6]


@pytest.mark.parametrize(
    ("late", "share"),
    [
        (0.03 * (STOPS > 1280), 0.03),
        (-3.0 * (STOPS > 1280), 3.0),
        (0.49 / RATE * (STOPS > 1280), 0.49 / RATE),
        (0.02 * np.sin(2 * np.pi * STOPS / RATE / 24), 0.02 * 2 * np.pi / 24),
    ],
)
def test_what_times_part_from_even_ones_within_a_second_is_measured(late: np.ndarray, share: float) -> None:
    found = unevenness(STOPS.tolist(), stamps(late))
    # windows are 1 to 1.06 s long, and the even spacing is found from the same stamps
    assert found is not None
    assert found.share == pytest.approx(share, rel=0.15)


@pytest.mark.parametrize(
    ("unit_us", "rate"), [(1, 256.0), (4, 243.7), (1000, 256.0), (1000, 243.7), (1000, 100.0)]
)
def test_rounded_stamps_are_even_and_a_pause_among_them_is_not(unit_us: int, rate: float) -> None:
    index = np.arange(3000)
    even = unevenness(index.tolist(), stamps(0.0 * index, unit_us, index, rate))
    pause = unevenness(index.tolist(), stamps(0.012 * (index > 1300), unit_us, index, rate))
    assert even is not None
    assert even.share == 0.0
    assert pause is not None
    assert pause.share > 0.009
    assert pause.index == 1301
