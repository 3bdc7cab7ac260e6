"""How much of a record is analysed, and where readings are missing, is said; too few a cycle are refused in words."""

import numpy as np
import pytest

from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import prepare
from mocks.generate import draw

SAMPLE = draw(None, 0.0, 700)
CYCLE = 0.2525
"""Seconds of a cycle at the bench's 3.96 Hz."""


def with_gap(start: float, cycles: float, *, as_zeros: bool = False) -> FreeDecay:
    """Return the release with readings missing from `start` s on."""
    first = round(start * SAMPLE.rate)
    missing = slice(first, first + round(cycles * CYCLE * SAMPLE.rate))
    valid = np.ones(len(SAMPLE.displacement), dtype=bool)
    valid[missing] = False
    reading = np.array(SAMPLE.displacement)
    reading[missing] = 0.0 if as_zeros else np.nan
    return FreeDecay(SAMPLE.rate, reading, valid=valid)


@pytest.mark.parametrize("as_zeros", [False, True])
def test_an_analysis_that_ends_at_a_gap_says_where_and_how_much_was_used(as_zeros):
    use = prepare(with_gap(3.2, 1.5, as_zeros=as_zeros)).use
    assert use.ended == "readings_missing"
    assert use.end_s == pytest.approx(3.2, abs=1.0 / SAMPLE.rate)
    assert use.missing_s == pytest.approx(1.5 * CYCLE, abs=1.0 / SAMPLE.rate)
    released = SAMPLE.truth["released_at_s"]
    whole = len(SAMPLE.displacement) / SAMPLE.rate - released
    assert use.share == pytest.approx(
        (3.2 - released - 0.03) / whole, abs=0.01
    )  # a fit begins 30 ms after the release
    share = round(100.0 * use.share)
    assert use.words == (
        f"the analysis ends at 3.20 s, where 0.38 s of readings are missing; {share} % of the record after the release "
        "was used"
    )


def test_a_short_gap_is_passed_over_and_a_gap_after_the_motion_does_not_matter():
    whole = prepare(FreeDecay(SAMPLE.rate, SAMPLE.displacement)).use
    assert whole.ended == "motion_too_small"
    for decay in (with_gap(3.2, 0.3), with_gap(7.5, 2.0)):
        use = prepare(decay).use
        assert use.ended == whole.ended
        assert use.end_s == pytest.approx(whole.end_s, abs=CYCLE)


def test_a_record_that_is_cut_is_used_to_its_end():
    use = prepare(FreeDecay(SAMPLE.rate, np.asarray(SAMPLE.displacement)[: round(3.5 * SAMPLE.rate)])).use
    assert use.ended == "record_ends"
    assert use.end_s == pytest.approx(use.length_s)
    assert use.share > 0.97  # all but the 30 ms in which the hand lets go


def test_a_gap_soon_after_the_release_is_what_a_refusal_names():
    with pytest.raises(
        NotIdentifiable, match=r"cycles of free motion lie before 1\.30 s, where 0\.38 s of readings"
    ):
        prepare(with_gap(1.3, 1.5))


@pytest.mark.parametrize("end_s", [1.78, 1.8])  # the fourth cycle ends at 1.802 s
def test_a_record_that_is_too_short_is_not_said_to_hold_as_many_cycles_as_are_needed(end_s):
    with pytest.raises(NotIdentifiable, match=r"Only 3\.[89] cycles .* at least four"):
        prepare(FreeDecay(SAMPLE.rate, np.asarray(SAMPLE.displacement)[: round(end_s * SAMPLE.rate)]))


@pytest.mark.parametrize("frequency", [3.0, 3.3, 3.7, 4.0])
def test_ten_readings_a_second_of_a_quick_motion_are_refused_with_the_rate_that_it_needs(frequency):
    time = np.arange(0.0, 40.0, 0.1)
    random = np.random.default_rng(0)
    reading = 0.02 * np.exp(-0.05 * time) * np.cos(2.0 * np.pi * frequency * time)
    with pytest.raises(NotIdentifiable) as refused:
        prepare(FreeDecay(10.0, reading + 2e-5 * random.standard_normal(len(time))))
    said = str(refused.value)
    assert f"10 readings a second of a motion at about {frequency:.2g} Hz" in said
    assert f"Record at {20 * frequency:.0f} Hz or faster." in said


def test_a_ripple_beside_a_slow_motion_is_not_what_must_be_sampled_faster():
    time, random = np.arange(0.0, 37.0, 0.1), np.random.default_rng(2)
    slow = 0.1 * np.exp(-0.05 * time) * np.cos(2.0 * np.pi * 0.112 * time)
    ripple = 0.01 * np.cos(2.0 * np.pi * 4.94 * time)
    with pytest.raises(NotIdentifiable) as refused:
        prepare(FreeDecay(10.0, slow + ripple + 0.003 * random.standard_normal(len(time))))
    assert "readings a second" not in str(refused.value)


def test_noise_alone_is_not_put_down_to_the_sampling():
    random = np.random.default_rng(1)
    with pytest.raises(NotIdentifiable) as refused:
        prepare(FreeDecay(10.0, random.standard_normal(400)))
    assert "readings a second" not in str(refused.value)
