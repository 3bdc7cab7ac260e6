import numpy as np
import pytest
from test_fit import fitted

from identify.fitting.baseline import refined_floor
from identify.preprocessing.noise import Noise


def with_known(found, **known):
    before = {c: known.get(c, Noise(1.0, np.inf, "nowhere")) for c in found.windows[0].channels}
    return refined_floor(found, 0, before, {})


def test_the_band_above_the_motion_gives_the_doubles_noise_where_nothing_was_known():
    _, truth, found = fitted()
    floor = with_known(found)
    for channel, true in (("displacement", truth["noise_m"]), ("acceleration", truth["noise_m_s2"])):
        noise = floor.channels[channel]
        assert noise.source == "band above the motion"
        assert (
            abs(noise.std - true) < 4.0 * noise.uncertainty + 0.05 * true
        )  # the converter's steps add a little


def test_two_estimates_that_agree_are_averaged_and_better_than_either():
    _, _, found = fitted()
    band = with_known(found).channels["acceleration"]
    known = Noise(band.std * 1.01, band.uncertainty, "rest")
    both = with_known(found, acceleration=known).channels["acceleration"]
    assert both.std == pytest.approx(band.std * 1.005, rel=1e-6)  # equal errors: the mean of the two
    assert both.uncertainty == pytest.approx(band.uncertainty / np.sqrt(2.0), rel=1e-6)
    assert "rest" in both.source
    assert "band" in both.source


def test_a_band_far_above_what_was_seen_at_rest_is_misfit_not_noise():
    _, _, found = fitted()
    band = with_known(found).channels["acceleration"]
    quiet = Noise(band.std / 2.0, band.uncertainty / 2.0, "rest")
    assert with_known(found, acceleration=quiet).channels["acceleration"] is quiet


def test_a_band_far_below_what_was_seen_at_rest_is_the_floor():
    _, _, found = fitted()
    band = with_known(found).channels["acceleration"]
    loud = Noise(band.std * 2.0, band.uncertainty, "rest")
    assert with_known(found, acceleration=loud).channels["acceleration"].std == pytest.approx(band.std)


def test_a_noise_less_well_known_leaves_chi_square_more_open():
    _, _, found = fitted()
    wide = {c: Noise(s, s * 0.2, "rest") for c, s in found.windows[0].sigma.items()}
    narrow = {c: Noise(s, s * 0.001, "rest") for c, s in found.windows[0].sigma.items()}
    # only the readings' number is left where the noise is known: sqrt(2 / degrees)
    least = np.sqrt(2.0 / found.degrees)
    known = refined_floor(found, 0, narrow, {}).chi_square_std
    assert least <= known < 1.3 * least
    assert refined_floor(found, 0, wide, {}).chi_square_std > known
