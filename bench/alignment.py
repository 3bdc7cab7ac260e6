"""How well the release and the lag are found."""

from collections.abc import Callable

import numpy as np

from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import align
from identify.preprocessing.release import Release, release_of
from mocks.generate import Sample, draw

TITLE = "Release, alignment and motion"

PAPER_RELEASES = (-0.025, -0.02, -0.015, -0.005, 0.02, 0.025)
SEEDS, QUICK_SEEDS = 540, 60


def run(quick: bool) -> str:
    seeds = range(QUICK_SEEDS if quick else SEEDS)
    samples = [_sample(seed) for seed in seeds]
    parts = (_lag_table(samples), _releases(samples))
    made = (
        f"{len(samples)} simulated releases of 8 s at 256 Hz: from -2.5 to 2.5 cm, or pushed; noise 5 um "
        "and 0.01 m/s^2, lag +-3 ms, hand up to 12 ms, gain error +-1 %."
    )
    return "\n\n".join((made, *parts))


def _sample(seed: int) -> Sample:
    rng = np.random.default_rng([seed, 77])
    hand = float(rng.integers(0, 2)) * float(rng.uniform(0.001, 0.012))
    common = {
        "noise_displacement": 5e-6,
        "noise_acceleration": 0.01,
        "release_time": hand,
        "gain_error": rng.uniform(-0.01, 0.01),
    }
    which = seed % 9
    if which < len(PAPER_RELEASES):
        return draw(None, 0.0, seed, amplitude=PAPER_RELEASES[which], **common)
    return draw(None, 0.0, seed, amplitude=0.0, velocity=float(rng.uniform(0.35, 0.6)), **common)


def _release_of(sample: Sample) -> Release:
    return release_of(
        FreeDecay(sample.rate, displacement=sample.displacement, acceleration=sample.acceleration)
    )


def _decay(
    sample: Sample, start: int = 0, stop: int | None = None, release: Release | None = None
) -> FreeDecay:
    span = slice(start, stop)
    known = {} if release is None else {"release": release.index, "rest": release.rest}
    return FreeDecay(
        sample.rate, displacement=sample.displacement[span], acceleration=sample.acceleration[span], **known
    )


def _cuts() -> tuple[tuple[str, Callable[[Sample, Release], FreeDecay]], ...]:
    second = 256
    return (
        ("from rest to rest", lambda sample, found: _decay(sample, release=found)),
        ("rest to mid-decay (1 s of motion)", lambda s, r: _decay(s, 0, r.settle + second, r)),
        ("mid-decay to rest", lambda s, r: _decay(s, r.settle)),
        ("mid-decay, 2 s of it", lambda s, r: _decay(s, r.settle + second // 8, r.settle + 2 * second)),
        ("mid-decay, first 0.5 s", lambda s, r: _decay(s, r.settle, r.settle + second // 2)),
    )


def _lag_table(samples: list[Sample]) -> str:
    rows = [
        "| record | error of the lag, us (rms) | over its standard error | refused |",
        "|---|---|---|---|",
    ]
    large = [(sample, _release_of(sample)) for sample in samples if abs(sample.truth["from_m"]) != 0.005]
    for name, cut in _cuts():
        rows.append(_lag_row(name, [(sample, cut(sample, found)) for sample, found in large]))
    small = [sample for sample in samples if abs(sample.truth["from_m"]) == 0.005]
    rows.append(
        _lag_row("rest to rest, from 0.5 cm", [(s, _decay(s, release=_release_of(s))) for s in small])
    )
    return "\n".join(rows)


def _lag_row(name: str, records: list[tuple[Sample, FreeDecay]]) -> str:
    lags, refused = [], 0
    for sample, decay in records:
        try:
            found = align(decay)
        except NotIdentifiable:
            refused += 1
            continue
        lags.append((found.lag.value - sample.truth["displacement_late_s"], found.lag.std))
    lag = np.array(lags)
    return f"| {name} | {1e6 * _rms(lag[:, 0]):.2f} | {_rms(lag[:, 0] / lag[:, 1]):.2f} | {refused} |"


def _releases(samples: list[Sample]) -> str:
    """Return how near the release is found: in both channels and in each alone, after an ideal and after a slow hand."""
    both = ("displacement", "acceleration")
    errors = [
        _release_errors(names, [s for s in samples if (s.truth["hand_s"] == 0.0) == ideal])
        for names in (both, both[:1], both[1:])
        for ideal in (True, False)
    ]
    within = [100 * np.mean(each <= 1.0) for each in errors]
    return (
        f"The release is found within a sample in {min(within):.1f} %, at most "
        f"{max(each.max() for each in errors):.2f} samples off."
    )


def _release_errors(names: tuple[str, ...], samples: list[Sample]) -> np.ndarray:
    """Return how far outside the hand's time the release is found, in samples, (samples,)."""
    outside = []
    for sample in samples:
        release = release_of(FreeDecay(sample.rate, **{name: getattr(sample, name) for name in names}))
        begun = sample.truth["released_at_s"] + (
            sample.truth["displacement_late_s"] if names == ("displacement",) else 0.0
        )
        late = release.time_s - begun
        outside.append(max(0.0, -late, late - sample.truth["hand_s"]) * sample.rate)
    return np.array(outside)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
