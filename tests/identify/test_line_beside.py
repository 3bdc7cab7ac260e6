"""A line of a sensor beside a force: where the floor is a guess, hum neither hides a force nor makes one."""

import re

import numpy as np
import pytest
from specimens import diagnosed
from test_fit import fitted

from identify.fitting.fit import Fit
from identify.fitting.misfit_errors import misfit_density
from identify.fitting.model_error import line_percent
from identify.free_decay import FreeDecay
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from mocks.generate import draw
from mocks.imperfections import IMPERFECTIONS


def release(effect: str | None, seed: int, *, mid_decay: bool) -> PreparedDecay:
    """Return a release under every imperfection at once, from the middle of the decay or of the displacement alone."""
    sample = draw(effect, 0.03 if effect else 0.0, seed, imperfections=IMPERFECTIONS, bits=12)
    if not mid_decay:
        return prepare(FreeDecay(sample.rate, displacement=sample.displacement))
    first = round(1.7 * sample.rate)
    return prepare(FreeDecay(sample.rate, sample.displacement[first:], sample.acceleration[first:]))


@pytest.mark.slow
@pytest.mark.parametrize(("effect", "mid_decay"), [("quadratic_damping", False), ("hysteresis", True)])
def test_a_force_is_named_beside_the_hum_that_keeps_it_from_a_guessed_floor(effect: str, mid_decay: bool):
    found = diagnosed(release(effect, 62000, mid_decay=mid_decay))
    assert found.verdict == "missing_effect"
    assert set(found.named) == {effect, "mains_hum"}
    assert found.baseline.adequate(found.final)
    assert "mains_hum" in found.final.model


def test_the_residual_of_the_true_model_is_as_dense_as_the_noise_around_any_frequency():
    found: Fit = fitted()[2]
    own = found.frequency
    density = [
        misfit_density(found, k * own, c) for k in np.arange(2.5, 14.0) for c in found.windows[0].channels
    ]
    # each of 24 is the mean of some 30 bins of one degree of two: 18 % apart, their mean 4 %, beside a floor known to 6 %
    assert np.mean(density) == pytest.approx(1.0, abs=0.2)
    assert max(density) < 2.0


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "mid_decay"), [(65001, False), (60100, True)])
def test_a_line_alone_that_is_too_small_to_be_worth_a_name_is_a_remark(seed: int, mid_decay: bool):
    found = diagnosed(release(None, seed, mid_decay=mid_decay))
    assert not found.baseline.floor_is_sure
    assert (found.verdict, found.named) == ("nothing_missing", ())
    assert "mains_hum" in found.final.model
    assert not any(suspect.claimed for suspect in found.suspects)
    line = next(suspect for suspect in found.suspects if suspect.effect.name == "mains_hum")
    said = re.search(r"has a line at ([\d.]+)[^,]*, ([\d.]+) % of its motion: too small", found.explanation)
    assert float(said.group(1)) == pytest.approx(line.parameters["f"].value, rel=0.01)
    assert float(said.group(2)) == pytest.approx(line_percent(line.fit, line.term), rel=0.1)
    assert float(said.group(2)) < 0.5


@pytest.mark.slow
def test_a_line_that_is_worth_a_name_is_named():
    sample = draw(None, 0.0, 65001, imperfections=IMPERFECTIONS, bits=12)
    motion = float(np.std(sample.displacement))
    hum = 0.02 * motion * np.sin(2.0 * np.pi * 50.0 * np.arange(len(sample.displacement)) / sample.rate)
    found = diagnosed(prepare(FreeDecay(sample.rate, displacement=sample.displacement + hum)))
    assert (found.verdict, found.named) == ("sensor_fault", ("mains_hum",))
