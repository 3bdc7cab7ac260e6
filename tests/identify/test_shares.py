"""Shares against closed forms of the double's own parameters, and their errors against draws from the covariance."""

from dataclasses import replace

import numpy as np
import pytest
from releases import drawn

from identify.diagnosis.shares import shares
from identify.effects.library import find_effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from identify.model.model import Term, base_model

AVERAGED = 2e-3
"""First order in what the cubic spring adds, 1.4 % of the frequency: the averaged motion is not the motion."""


@pytest.fixture(scope="module")
def stiffening():
    """Return a release with a cubic spring, a fit with it, and the truth."""
    prepared, truth = drawn("cubic_stiffness", 0.02, 44)
    base = fit_baseline((prepared,), base_model()).fit
    model = base_model().plus(Term(find_effect("cubic_stiffness")))
    start = base.point | {"cubic_stiffness.k3": 4e4, "linear_stiffness.k": truth["stiffness_per_mass"]}
    return prepared, fit(model, (prepared.window,), start, base.frequency), truth


def closed(at, mu_0, mu_1, k3):
    """Return largest force, loss in % and shift in Hz of dry friction, a viscous damper and a cubic spring."""
    w = 2.0 * np.pi * at.frequency
    dry, wet = 4.0 * mu_0 / (np.pi * w * at.amplitude), mu_1 + 0.0 * mu_0
    forces = (mu_0, mu_1 * w * at.amplitude, k3 * at.amplitude**3)
    losses = (100.0 * dry / (dry + wet), 100.0 * wet / (dry + wet), 0.0 * k3)
    shift = (w - np.sqrt(w**2 - 0.75 * k3 * at.amplitude**2)) / (2.0 * np.pi)
    return np.array(forces), np.array(losses), np.array([0.0 * k3, 0.0 * k3, shift])


def test_shares_are_those_of_the_closed_forms_at_both_ends_of_the_record(stiffening):
    prepared, found, truth = stiffening
    both = shares((prepared,), found)
    assert both[0].amplitude == prepared.amplitude > 10.0 * both[1].amplitude
    k3 = truth["parameters"]["k3"]
    for at in both:
        forces, losses, shifts = closed(at, truth["mu_0"], truth["mu_1"], k3)
        assert [one.effect for one in at.effects] == [
            "coulomb_friction",
            "viscous_damping",
            "cubic_stiffness",
        ]
        for one, force, loss, shift in zip(at.effects, forces, losses, shifts, strict=True):
            assert one.force.value == pytest.approx(force, abs=4.5 * one.force.std + AVERAGED * force)
            assert one.loss_percent.value == pytest.approx(
                loss, abs=4.5 * one.loss_percent.std + AVERAGED * loss
            )
            assert one.frequency_hz.value == pytest.approx(shift, abs=AVERAGED * shift + 1e-9)
            assert one.frequency_percent.value == pytest.approx(
                100.0 * one.frequency_hz.value / at.frequency, rel=1e-9
            )


def test_the_share_of_all_forces_is_that_of_the_largest_together(stiffening):
    prepared, found, _ = stiffening
    at = shares((prepared,), found)[0]
    mu_0, mu_1, k3 = (
        found.values[n].value for n in ("coulomb_friction.mu_0", "viscous_damping.mu_1", "cubic_stiffness.k3")
    )
    turn, w = np.linspace(0.0, 2.0 * np.pi, 20001), 2.0 * np.pi * at.frequency
    u, v = at.amplitude * np.cos(turn), -at.amplitude * w * np.sin(turn)
    whole = np.max(np.abs(k3 * u**3 + mu_1 * v + mu_0 * np.sign(v)))
    for one in at.effects:
        # 512 points a cycle: the largest is missed by half a step at most
        assert one.force_percent.value == pytest.approx(100.0 * one.force.value / whole, rel=1e-3)


def test_errors_are_the_spread_over_draws_from_the_covariance(stiffening):
    prepared, found, _ = stiffening
    names = ("coulomb_friction.mu_0", "viscous_damping.mu_1", "cubic_stiffness.k3")
    places = [found.names.index(name) for name in names]
    covariance = found.covariance[np.ix_(places, places)]
    draws = np.random.default_rng(1).multivariate_normal(found.theta[places], covariance, 4000).T
    for at in shares((prepared,), found):
        spread = [part.std(axis=1) for part in closed(at, *draws)]
        for one, force, loss, shift in zip(at.effects, *spread, strict=True):
            # 4000 draws know a spread to 1.1 %
            assert one.force.std == pytest.approx(force, rel=0.05)
            assert one.loss_percent.std == pytest.approx(loss, rel=0.05, abs=1e-9)
            assert one.frequency_hz.std == pytest.approx(shift, rel=0.05, abs=1e-12)


def test_with_a_mass_forces_are_in_newton(stiffening):
    prepared, found, _ = stiffening
    alone = shares((prepared,), found)[0].effects[0].force
    heavy = shares((replace(prepared, mass=21.36),), found)[0].effects[0].force
    assert (alone.unit, heavy.unit) == ("m/s^2", "N")
    assert heavy.value == pytest.approx(21.36 * alone.value)
    assert heavy.std == pytest.approx(21.36 * alone.std)


def test_a_parameter_at_its_bound_leaves_its_own_errors_unknown_and_the_others_known(stiffening):
    prepared, found, _ = stiffening
    held = replace(
        found,
        values=found.values
        | {"coulomb_friction.mu_0": replace(found.values["coulomb_friction.mu_0"], value=0.0, std=np.inf)},
    )
    for at in shares((prepared,), held):
        dry, wet, spring = at.effects
        assert dry.force.value == 0.0
        assert np.isinf(dry.force.std)
        assert wet.loss_percent.value == pytest.approx(100.0)
        assert np.isfinite([wet.force.std, spring.frequency_hz.std]).all()


def test_a_line_takes_no_part_in_loss_and_frequency(stiffening):
    prepared, found, _ = stiffening
    model = found.model.plus(Term(find_effect("harmonic_forcing")))
    start = found.point | {f"harmonic_forcing.{n}": v for n, v in (("amp", 0.1), ("f", 16.0), ("phase", 0.5))}
    shaken = fit(model, (prepared.window,), start, found.frequency, tolerance=1e3)
    line = shares((prepared,), shaken)[1].effects[-1]
    assert line.force.value == shaken.values["harmonic_forcing.amp"].value
    assert np.isnan([line.loss_percent.value, line.frequency_hz.value]).all()


def test_what_a_record_leaves_uncertain_by_more_than_the_whole_is_not_stated(stiffening):
    prepared, found, _ = stiffening
    place, spread = found.names.index("viscous_damping.mu_1"), np.ones(len(found.names))
    spread[place] = 5.0 * found.theta[place] / np.sqrt(found.covariance[place, place])
    large, _ = shares((prepared,), replace(found, covariance=found.covariance * np.outer(spread, spread)))
    dry, wet, spring = large.effects
    assert np.isnan([dry.loss_percent.value, wet.loss_percent.value]).all()
    assert np.isfinite([dry.force.value, spring.force.value, spring.frequency_hz.value]).all()
    assert shares((prepared,), replace(found, covariance=1e20 * found.covariance)) == ()
