from dataclasses import replace

import numpy as np
import pytest
from releases import CALIBRATED, drawn
from scipy import stats
from test_fit import fitted

from identify.diagnosis.ladder import add_effect, first_step, needless_share
from identify.effects.library import find_effect
from identify.estimate import Estimate
from identify.fitting.baseline import fit_baseline
from identify.fitting.corrected_faults import (
    UNSTATED_GAIN_UNCERTAINTY,
    CorrectedFault,
    corrected_faults,
    unnamed_faults,
)
from identify.model.model import Term


def with_gain(found, value, std):
    return replace(found, values=found.values | {"gain": Estimate(value, std, "1")})


def gain_fault(prepared, found):
    decays = prepared if isinstance(prepared, tuple) else (prepared,)
    return next(f for f in corrected_faults(decays, found) if f.term.effect.name == "channel_gain")


def test_a_gain_is_weighed_against_its_error_and_what_the_calibration_promises():
    prepared, _, found = fitted()
    allowed = 0.01
    prepared = replace(prepared, window=prepared.window.with_(gain_uncertainty=allowed))
    fault = gain_fault(prepared, with_gain(found, 1.03, 0.004))
    variance = 0.004**2 * max(found.reduced, 1.0) + allowed**2
    assert fault.drop == pytest.approx(0.03**2 / variance)
    assert fault.parameters["error"].value == pytest.approx(0.03)
    assert fault.parameters["error"].std == pytest.approx(np.sqrt(variance))


def test_a_calibration_that_says_nothing_leaves_open_what_ordinary_sensors_are_off():
    prepared, _, found = fitted()
    prepared = replace(prepared, window=prepared.window.with_(gain_uncertainty=0.0))
    fault = gain_fault(prepared, with_gain(found, 1.0 + 3.0 * UNSTATED_GAIN_UNCERTAINTY, 1e-9))
    assert fault.drop == pytest.approx(9.0, rel=1e-3)


def test_lost_readings_are_no_surprise_where_all_readings_err_as_much():
    fault = CorrectedFault(Term(find_effect("dropouts"), {"channel": "acceleration"}), 39.0, 5, {})
    assert fault.p_value < 1e-4
    assert replace(fault, misfit=39.0 / 5.0).p_value == 1.0


def test_an_ordinary_gain_error_is_remarked_on_and_no_fault():
    prepared, truth = drawn("channel_gain", 0.01, 7200)
    fault = gain_fault(prepared, fit_baseline((prepared,), fitted()[2].model).fit)
    assert abs(truth["parameters"]["error"]) == pytest.approx(0.01, rel=0.01)
    assert fault.remarked
    assert fault.p_value > 0.05


@pytest.mark.parametrize(
    ("gain", "stated", "said"),
    [
        (
            1.01,
            0.0,
            "differ by 1.00 ± 0.40 %; a standard uncertainty of 3 % of their calibrations is assumed",
        ),
        (
            0.99,
            0.005,
            "differ by 1.00 ± 0.40 %; a standard uncertainty of 0.5 % of their calibrations is stated",
        ),
        (1.2, 0.0, "differ by 20.00 ± 0.40 %; a standard uncertainty of 3 %"),
    ],
)
def test_a_remark_on_a_gain_says_the_difference_and_what_is_left_open(gain, stated, said):
    prepared, _, found = fitted()
    prepared = replace(prepared, window=prepared.window.with_(gain_uncertainty=stated))
    own = 0.004 / max(found.reduced, 1.0) ** 0.5  # the misfit widens it
    assert said in gain_fault(prepared, with_gain(found, gain, own)).words


def test_releases_of_one_pair_of_sensors_share_its_calibration():
    prepared, _, found = fitted()
    prepared = replace(prepared, window=prepared.window.with_(gain_uncertainty=0.01))
    one = with_gain(found, 1.03, 0.004)
    three = replace(
        found,
        windows=found.windows * 3,
        predicted=found.predicted * 3,
        values={f"gain[{i}]": Estimate(1.03, 0.004, "1") for i in range(3)},
    )
    single, joint = gain_fault(prepared, one), gain_fault((prepared,) * 3, three)
    own = 0.004**2 * max(found.reduced, 1.0)
    assert joint.drop == pytest.approx(0.03**2 / (own / 3 + 0.01**2))  # and not three times one's
    assert single.drop < joint.drop < 1.2 * single.drop


def test_lost_readings_that_lie_where_noise_would_put_them_are_no_fault():
    fault = CorrectedFault(Term(find_effect("dropouts")), 16.0, 3, {})
    # the tail of three degrees at 16 is 1.1e-3, that of one degree at 12 is 5e-4: less improbable than a fault must be
    assert stats.chi2.sf(16.0, 3) > stats.chi2.sf(12.0, 1)
    assert fault.p_value > 0.05
    assert replace(fault, drop=1000.0).p_value < 1e-4


def test_a_gain_that_the_record_does_not_determine_is_no_fault():
    prepared, _, found = fitted()
    assert not corrected_faults((prepared,), with_gain(found, 1.5, np.inf))


def test_the_doubles_gain_error_is_found():
    prepared, truth = drawn("channel_gain", 0.01, 7200, gain_uncertainty=CALIBRATED)
    found = fit_baseline((prepared,), fitted()[2].model).fit
    fault = gain_fault(prepared, found)
    channel = truth["parameters"]["channel"]
    factor = 1.0 + truth["parameters"]["error"]
    ratio = truth["gain"] * (factor if channel == "acceleration" else 1.0 / factor)
    error = fault.parameters["error"]
    assert abs(error.value - (ratio - 1.0)) < 4.0 * error.std
    assert fault.drop > 100.0  # 1 % against 0.02 % allowed


def test_lost_readings_are_counted_and_weighed_by_how_far_off_they_lie():
    prepared, _, found = fitted()
    lost = np.zeros(len(prepared.window), dtype=bool)
    lost[[100, 300, 500, 700]] = True
    prepared = replace(prepared, lost={"displacement": lost})
    fault = next(f for f in corrected_faults((prepared,), found) if f.term.effect.name == "dropouts")
    off = found.residual("displacement")[lost] / prepared.window.sigma["displacement"]
    assert fault.readings == 4
    assert fault.drop == pytest.approx(float(off @ off))
    assert fault.parameters["share"].value == pytest.approx(4 / len(prepared.window))


def test_two_lost_readings_are_an_accident():
    prepared, _, found = fitted()
    lost = np.zeros(len(prepared.window), dtype=bool)
    lost[[100, 300]] = True
    names = [
        f.term.effect.name for f in corrected_faults((replace(prepared, lost={"displacement": lost}),), found)
    ]
    assert "dropouts" not in names


def test_a_model_that_names_a_fault_owns_up_to_it():
    prepared, _, found = fitted()
    found = with_gain(found, 1.03, 0.001)
    named = replace(found, model=found.model.plus(Term(find_effect("channel_gain"))))
    assert unnamed_faults((prepared,), found)[0].drop > 0.0
    assert unnamed_faults((prepared,), named) == ()


def test_naming_lost_readings_is_needed_though_every_fit_leaves_them_out():
    prepared, _ = drawn("dropouts", 0.02, 41)
    before = first_step(prepared)
    named = add_effect(before, find_effect("dropouts"))
    assert named.error.chi_square < 0.5 * before.error.chi_square
    assert needless_share(named, before) is None
