"""The pipeline: each step takes the last one's value; a step that cannot be done says why, and the others still run."""

import json

import numpy as np
import pytest

from daq.recording import Channel, Recording
from identify.errors import NotIdentifiable
from mocks import generate
from station.output import print_json
from station.results.identification_document import identification_document
from station.story.pipeline import identify
from station.story.preparation import Options, free_decay
from station.text.identification_text import uncorrected

UNITS = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s^2"}


def record(rate, **channels):
    samples = np.array(list(channels.values()))
    described = tuple(Channel(name, name, UNITS.get(name, "N")) for name in channels)
    return Recording(rate, described, samples, np.ones(samples.shape[1], dtype=bool))


@pytest.fixture(scope="module")
def drawn():
    return generate.draw(None, 0.0, 11)


@pytest.fixture(scope="module")
def both(drawn):
    recording = record(drawn.rate, displacement=drawn.displacement, acceleration=drawn.acceleration)
    return identify(recording, Options(mass=21.36))


def test_both_methods_find_what_the_testbed_was_made_of(both, drawn):
    truth = drawn.truth
    for method in (both.wavelet, both.restoring_force):
        # The limits: K 0.04 %, mu_0 0.6 %, mu_1 1.2 %; here three times those, for a single draw.
        assert method.stiffness.value == pytest.approx(21.36 * truth["stiffness_per_mass"], rel=1.2e-3)
        assert method.damping[0].value == pytest.approx(truth["mu_0"], rel=0.018)
        assert method.damping[1].value == pytest.approx(truth["mu_1"], rel=0.036)
        assert method.stiffness.unit == "N/m"
    assert both.refusals == {}


def test_the_lag_is_found_and_without_it_the_viscous_damping_is_wrong_by_as_much_as_the_paper_says(
    both, drawn
):
    lag = drawn.truth["displacement_late_s"]
    assert both.alignment.lag.value == pytest.approx(lag, abs=16e-6)  # 4 us rms wanted; four times that
    spoiled = float(uncorrected(both).split("= ")[1].split()[0])
    true = 21.36 * (drawn.truth["mu_1"] + drawn.truth["stiffness_per_mass"] * lag)
    assert spoiled == pytest.approx(true, abs=21.36 * 0.02)


def test_one_channel_is_identified_and_the_lag_is_refused_in_words(drawn):
    for name in ("displacement", "acceleration"):
        result = identify(record(drawn.rate, **{name: getattr(drawn, name)}), Options())
        assert result.alignment is None
        assert "without an acceleration" in result.refusals["alignment"].lower()
        assert result.wavelet is not None
        assert result.wavelet.stiffness.unit == "1/s^2"
        assert result.wavelet.stiffness.value == pytest.approx(drawn.truth["stiffness_per_mass"], rel=2e-3)


def test_a_record_without_any_motion_is_refused_in_words():
    noise = np.random.default_rng(1).standard_normal(2048) * 1e-6
    with pytest.raises(NotIdentifiable):
        identify(record(256.0, displacement=noise), Options())


def test_a_record_without_a_channel_of_motion_is_refused_by_its_channels_names():
    with pytest.raises(NotIdentifiable, match="temperature"):
        free_decay(record(256.0, temperature=np.zeros(2048)), Options())


def test_a_force_that_goes_on_drives_and_a_hammer_does_not():
    time = np.arange(2048) / 256
    hammer = np.where(time < 0.1, 100.0, 0.0)
    shaker = np.random.default_rng(2).standard_normal(2048)
    motion = np.exp(-time) * np.cos(25 * time)
    assert not free_decay(record(256.0, displacement=motion, force=hammer), Options()).driven
    assert free_decay(record(256.0, displacement=motion, force=shaker), Options()).driven


def test_a_force_is_divided_by_the_mass_where_that_is_known():
    recording = record(256.0, displacement=np.ones(64), force=np.full(64, 10.0))
    assert np.all(free_decay(recording, Options(mass=5.0)).force == 2.0)
    assert np.all(free_decay(recording, Options()).force == 10.0)


def test_the_document_has_the_keys_that_other_programs_rely_on(both):
    document = identification_document("x", both)
    assert document["release"]["kind"] == "displaced"
    assert set(document["alignment"]["lag_s"]) == {"value", "std", "unit"}
    assert set(document["alignment"]["gain"]) == {"value", "std", "unit"}
    for name in ("wavelet", "restoring_force"):
        method = document[name]
        assert set(method["stiffness"]) == {"value", "std", "unit"}
        assert [item["unit"] for item in method["damping"]][:2] == ["m/s^2", "1/s"]
        assert len(method["damping"]) == method["order"] + 1
        assert len(method["mse_percent_by_order"]) == 4
    assert document["release"]["amplitude"] == pytest.approx(both.decay.displacement[:150].mean(), abs=5e-4)


def test_a_document_never_holds_a_number_that_json_has_not(capsys):
    print_json({"a": [float("nan"), (1.0, float("inf"))], "b": {"c": 2}})
    assert json.loads(capsys.readouterr().out) == {"a": [None, [1.0, None]], "b": {"c": 2}}


def test_both_methods_have_the_orders_that_one_of_them_needs():
    """A hardening spring, in one channel: the backbone bends, and the surface was asked for a straight line."""
    time = np.arange(0.0, 20.0, 1 / 256)
    amplitude = 0.02 * np.exp(-0.15 * time)
    frequency = np.sqrt(600.0 + 0.75 * 2e4 * amplitude**2)
    phase = np.cumsum(frequency) / 256
    noise = np.random.default_rng(5).normal(0.0, 2e-6, len(time))
    result = identify(record(256.0, displacement=amplitude * np.cos(phase) + noise), Options())
    assert result.wavelet.stiffness_by_order.keys() >= {1, 3}
    assert result.restoring_force.stiffness_by_order.keys() >= {1, 3}
    assert result.restoring_force.order == result.wavelet.order
