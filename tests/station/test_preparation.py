"""From a session to a release that can be fitted: the mass, and the gain that the certificates leave open."""

import numpy as np
import pytest
from synthetic import decay

from daq.recording import Channel, Recording
from daq.session import Session
from daq.session_info import SessionInfo
from identify.errors import NotIdentifiable
from station.settings import Settings, Specimen
from station.story.preparation import Options, free_decay, options_for, prepare_session


def session_of(folder, uncertainties=(None, None), samples=slice(None), info=None):
    made = decay()
    channels = tuple(
        Channel(name, name, unit, calibration_uncertainty=uncertainty)
        for name, unit, uncertainty in zip(
            ("displacement", "acceleration"), ("m", "m/s^2"), uncertainties, strict=True
        )
    )
    readings = np.array([made.displacement, made.acceleration])[:, samples]
    recording = Recording(made.rate, channels, readings, np.ones(readings.shape[1], dtype=bool))
    return Session.create_imported(folder / "one", recording, None, info or SessionInfo())


def test_the_gain_is_as_uncertain_as_both_certificates_leave_it(tmp_path):
    prepared = prepare_session(session_of(tmp_path, (0.003, 0.004)), Settings())
    assert prepared.window.gain_uncertainty == pytest.approx(0.005)


def test_without_certificates_the_gain_is_taken_as_it_is(tmp_path):
    assert prepare_session(session_of(tmp_path), Settings()).window.gain_uncertainty == 0.0


def test_a_record_that_is_too_short_is_refused_by_its_sessions_name(tmp_path):
    with pytest.raises(NotIdentifiable, match=r"^one: "):
        prepare_session(session_of(tmp_path, samples=slice(0, 260)), Settings())


def test_the_mass_given_comes_before_the_sessions_and_that_before_the_settings(tmp_path):
    settings = Settings(specimen=Specimen(mass_kg=3.0, mass_std_kg=0.3))
    weighed = session_of(tmp_path / "a", info=SessionInfo(mass_kg=2.0, mass_std_kg=0.2))
    assert options_for(weighed, settings, 1.0) == Options(1.0, None)
    assert options_for(weighed, settings) == Options(2.0, 0.2)
    assert options_for(session_of(tmp_path / "b"), settings) == Options(3.0, 0.3)


def test_stated_delays_become_a_lag_with_its_error_and_the_rate_keeps_its_own():
    channels = (
        Channel("displacement", "displacement", "m", group_delay_s=4.1e-3),
        Channel("acceleration", "acceleration", "m/s^2", group_delay_s=5.0e-3),
    )
    made = decay()
    readings = np.array([made.displacement, made.acceleration])
    valid = np.ones(readings.shape[1], dtype=bool)
    found = free_decay(Recording(made.rate, channels, readings, valid, rate_std=0.01), Options())
    assert found.stated_lag is not None
    assert found.stated_lag.value == pytest.approx(-0.9e-3)
    assert found.stated_lag.std == pytest.approx(0.15 * np.hypot(4.1e-3, 5.0e-3))
    assert found.rate_std == 0.01
    silent = tuple(Channel(c.name, c.quantity, c.unit) for c in channels)
    assert free_decay(Recording(made.rate, silent, readings, valid), Options()).stated_lag is None
