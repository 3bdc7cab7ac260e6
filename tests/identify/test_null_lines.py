from types import SimpleNamespace

import numpy as np

from identify.diagnosis.null_lines import line_drops
from identify.effects.library import find_effect
from identify.model.model import Term
from identify.preprocessing.fit_window import FitWindow

SAMPLES, RATE, SIGMA = 600, 50.0, 2e-6


def record(first: int, last: int, *, segment: bool) -> FitWindow:
    n = last - first
    return FitWindow(
        rate=RATE,
        time=0.3 + first / RATE,
        readings={"displacement": np.zeros(n)},
        used={"displacement": np.ones(n, dtype=bool)},
        sigma={"displacement": SIGMA},
        lead=0,
        segment=segment,
    )


def drops(*windows: FitWindow) -> np.ndarray:
    noise = np.random.default_rng(6).standard_normal((SAMPLES, 8))
    return line_drops(SimpleNamespace(windows=windows), Term(find_effect("harmonic_forcing")), noise)


def test_a_line_gains_as_much_by_chance_from_the_pieces_of_a_record_as_from_the_whole():
    half = SAMPLES // 2
    pieces = (record(0, half, segment=True), record(half, SAMPLES, segment=True))
    np.testing.assert_allclose(drops(*pieces), drops(record(0, SAMPLES, segment=False)), rtol=1e-9)


def test_pieces_of_a_prime_number_of_readings_gain_by_chance_what_their_neighbours_do():
    def median(samples: int) -> float:
        noise = np.random.default_rng(7).standard_normal((samples, 400))
        half = samples // 2
        windows = (record(0, half, segment=True), record(half, samples, segment=True))
        found = line_drops(SimpleNamespace(windows=windows), Term(find_effect("harmonic_forcing")), noise)
        return float(np.median(found))

    assert abs(median(601) - median(600)) < 0.4  # its standard error from 400 draws is 0.15
