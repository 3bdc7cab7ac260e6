"""Sensors that bend or are slow: told from physics where another channel does not show it, and left alone where none is."""

import numpy as np
import pytest
from releases import drawn, ready
from specimens import diagnosed

from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.library import find_effect
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from mocks.generate import draw

BENDS = ["sensor_nonlinearity", "sensor_bandwidth"]


def bent(channel, kind, share, seed=9300):
    """A release with one channel that bends by `share` of its largest reading, and the coefficient."""
    peak = np.max(np.abs(getattr(draw(None, 0.0, seed), channel)))
    coefficient = share / peak ** {"quadratic": 1, "cubic": 2}[kind]
    pinned = {"quadratic": 0.0, "cubic": 0.0} | {kind: coefficient, "channel": channel}
    return drawn("sensor_nonlinearity", 0.0, seed, parameters={"sensor_nonlinearity": pinned})[0], coefficient


@pytest.mark.parametrize(("channel", "kind"), [("displacement", "quadratic"), ("acceleration", "cubic")])
def test_a_sensor_that_bends_is_corrected_by_what_it_bends(channel, kind):
    prepared, true = bent(channel, kind, 0.005)
    there = add_effect(first_step((prepared,)), find_effect("sensor_nonlinearity"))
    assert there.fit.model.terms[-1].channel == channel
    assert there.at_floor
    found = there.fit.values[f"sensor_nonlinearity.{kind}"]
    assert abs(found.value - true) < 4.5 * found.std  # 1 in 150000 by chance


@pytest.mark.slow
def test_a_thousandth_of_the_range_is_seen_and_is_not_called_physics():
    found = diagnose((bent("displacement", "quadratic", 0.001)[0],))
    assert found.named == ("sensor_nonlinearity",)
    assert found.suspects[0].term.channel == "displacement"


@pytest.mark.slow
def test_a_slow_sensor_is_named_by_what_it_rounds_off():
    pinned = {"sensor_bandwidth": {"fc": 12.0, "channel": "displacement"}}
    found = diagnosed(drawn("sensor_bandwidth", 0.0, 9300, parameters=pinned)[0], also="sensor_bandwidth")
    assert found.named == ("sensor_bandwidth",)
    corner = found.suspects[0].parameters["fc"]
    assert abs(corner.value - 12.0) < 4.5 * corner.std


@pytest.mark.parametrize("name", BENDS)
def test_one_channel_cannot_show_it(name):
    sample = draw(None, 0.0, 9300)
    alone = ready(sample.rate, sample.displacement, None)
    with pytest.raises(NotIdentifiable, match=f"no channel that could show {name}"):
        add_effect(first_step((alone,)), find_effect(name))


def test_the_roll_off_is_that_of_a_first_order_filter():
    time, corner, frequency = np.arange(4000) / 1000.0, 9.0, 4.0
    w = 2.0 * np.pi * frequency
    seen = find_effect("sensor_bandwidth").observe(time, np.sin(w * time), np.array([corner, 0.0]))
    expected = np.imag(np.exp(1j * w * time) / (1.0 + 1j * frequency / corner))
    # Straight between samples: (w h)^2 / 12 of the reading, 5e-5; after 0.3 s the beginning is e^-17.
    np.testing.assert_allclose(seen[300:], expected[300:], atol=1e-4)


@pytest.mark.slow
def test_an_accelerometer_turned_over_and_in_another_unit_hides_no_force():
    turned = -1000.0 / 9.80665
    sample = draw("cubic_stiffness", 0.02, 77, amplitude=0.02)
    found = diagnosed(FreeDecay(sample.rate, sample.displacement, turned * sample.acceleration))
    assert found.named == ("cubic_stiffness",)
    assert found.final.values["gain"].value == pytest.approx(turned, rel=1e-3)
