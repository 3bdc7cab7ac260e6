from functools import cache

import numpy as np
import pytest
from decays_in_closed_form import exponential
from releases import drawn
from scipy.integrate import solve_ivp

import identify
from identify.effects.library import LIBRARY, find_effect
from identify.fitting.baseline import fit_baseline, residual_lines
from identify.fitting.fit import fit_at
from identify.fitting.model_error import motion_percent
from identify.free_decay import FreeDecay
from identify.judging.suspects import candidate_terms, try_terms
from identify.model.model import Term, base_model
from identify.preprocessing.aligned_decay import locate_and_align
from identify.preprocessing.prepared_decay import PreparedDecay, prepare


@cache
def hummed():
    prepared, truth = drawn("mains_hum", 0.01, 7301)
    return fit_baseline((prepared,), base_model()), truth


@cache
def hardened():
    prepared, truth = drawn("cubic_stiffness", 0.01, 7301)
    return fit_baseline((prepared,), base_model()), truth


def test_the_strongest_line_of_the_misfit_is_the_doubles_hum():
    start, truth = hummed()
    hum = truth["parameters"]
    f, amplitude, _ = residual_lines(start.fit)[hum["channel"]][0]
    assert f == pytest.approx(hum["f"], abs=0.02)  # a fifth of a bin of a span of 5 to 8 s
    assert amplitude == pytest.approx(
        hum["amp"], rel=0.1
    )  # noise of 0.01 over some 1500 readings, and the taper


def test_every_effect_that_the_model_lacks_is_a_suspect_and_no_other():
    start, _ = hummed()
    terms = candidate_terms(base_model(), LIBRARY, start.fit.windows[0])
    names = {t.effect.name for t in terms}
    corrected = {"channel_lag", "channel_gain", "dropouts"}
    for_angles_only = {"pendulum_stiffness"}
    assert names == {e.name for e in LIBRARY} - set(base_model().names) - corrected - for_angles_only


def test_a_fault_is_suspected_in_the_channels_there_are():
    start, _ = hummed()
    window = start.fit.windows[0]
    alone = window.with_(readings={"displacement": window.readings["displacement"]})
    terms = candidate_terms(base_model(), LIBRARY, alone)
    assert {t.channel for t in terms if t.effect.kind == "sensor"} == {"displacement"}


def test_slow_faults_are_no_suspects_where_every_episode_has_offsets_of_its_own():
    window = hummed()[0].fit.windows[0].with_(segment=True)
    assert all(t.effect.kind == "physics" for t in candidate_terms(base_model(), LIBRARY, window))


def test_the_hidden_effect_gains_most_and_its_strength_is_found():
    start, truth = hardened()
    terms = tuple(
        Term(find_effect(n)) for n in ("cubic_stiffness", "quadratic_damping", "quadratic_stiffness")
    )
    counted: list[tuple[int, int]] = []
    tried = try_terms(
        start.decays, start.fit, terms, counted=lambda done, whole: counted.append((done, whole))
    )
    assert counted == [(done, 6) for done in range(1, 7)]  # each begun, and each fitted to the end
    assert tried[0].name == "cubic_stiffness"
    assert [-c.evidence for c in tried] == sorted(-c.evidence for c in tried)
    found = tried[0].fit.values["cubic_stiffness.k3"]
    assert abs(found.value - truth["parameters"]["k3"]) < 4.0 * found.std


def test_one_term_alone_comes_to_what_it_came_to_among_others():
    start, _ = hardened()
    terms = tuple(Term(find_effect(name)) for name in ("quadratic_damping", "cubic_stiffness"))
    (alone,) = try_terms(start.decays, start.fit, terms[1:])
    among = next(c for c in try_terms(start.decays, start.fit, terms) if c.name == alone.name)
    assert alone.fit.chi_square == pytest.approx(
        among.fit.chi_square, abs=0.05
    )  # where a descent stops: 0.02


def test_no_force_is_left_with_more_than_the_model_without_it_leaves():
    """Noise of a twentieth of the amplitude: the equation error sees springs from which the motion runs away."""
    time = np.arange(390) / 30.0
    u = exponential(time, 0.9, 0.75, 0.025)[0] + 0.04 * np.random.default_rng(0).standard_normal(390)
    prepared = identify.prepare(identify.FreeDecay(30.0, displacement=u, unit="rad"))
    start = fit_baseline((prepared,), base_model())
    terms = tuple(Term(find_effect(n)) for n in ("pendulum_stiffness", "quintic_stiffness"))
    tried = try_terms((prepared,), start.fit, terms)
    assert len(tried) == 2
    assert all(candidate.fit.chi_square < 1.01 * start.fit.chi_square for candidate in tried)


def swing(angle: float, rate: float, seconds: float, noise: float, seed: int) -> PreparedDecay:
    """A pendulum u'' + 32.5 sin u + 0.0166 u' = 0 filmed in mid-swing, from an angle (rad) and a velocity (rad/s)."""
    time = np.arange(int(30.0 * seconds)) / 30.0
    run = solve_ivp(
        lambda _, s: (s[1], -32.5 * np.sin(s[0]) - 0.0166 * s[1]),
        (0.0, time[-1]),
        (angle, rate),
        t_eval=time,
        rtol=1e-9,
        atol=1e-11,
    )
    seen = run.y[0] + noise * np.random.default_rng(seed).standard_normal(len(time))
    return prepare(locate_and_align(FreeDecay(30.0, seen, unit="rad")))


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_effect_does_not_begin_from_the_false_zero_of_a_model_that_lost_the_phase(seed: int) -> None:
    """Two releases, from 1.4 and 0.64 rad, in noise of 0.12 rad: the usual model leaves all of the motion, at a chi-square
    that would pass for near.
    """
    decays = (swing(1.12, 4.7, 22.2, 0.12, seed), swing(-0.52, 2.18, 12.4, 0.12, seed + 9))
    usual = fit_baseline(decays, base_model()).fit
    astray = {
        "displacement[0]": -0.04,
        "velocity[0]": 1.3,
        "displacement_offset[0]": 0.9,
        "linear_stiffness.k": 31.0,
    }
    lost = fit_at(usual.problem, usual.problem.theta(usual.point | astray))
    assert lost.reduced < 100.0
    assert motion_percent(lost) > 90.0
    found, *_ = try_terms(decays, lost, (Term(find_effect("pendulum_stiffness")),))
    assert motion_percent(found.fit) < 30.0
