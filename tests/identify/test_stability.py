"""Cycles drawn again: a law that is there leads in all drawings, of two that are not told apart neither does."""

from collections import Counter
from types import SimpleNamespace

import numpy as np
import pytest

from identify.curves.averaged_law import law_of
from identify.curves.curve_regression import CurveRegression
from identify.curves.decay_curve import DecayCurve
from identify.curves.stability import RESAMPLINGS, Contender, drawn, leaders
from identify.effects.library import find_effect
from identify.model.model import Term, base_model

FREQUENCY, STEP = 24.0, 0.26
VISCOUS = 0.2


def curve(law, strength: float, scatter: float, seed: int = 0) -> DecayCurve:
    """Return a decay that loses by a viscous damper and one law, its amplitudes read with a relative scatter."""
    amplitude = [0.02]
    for _ in range(60):
        c_eq = np.interp(amplitude[-1], law.amplitudes, law.signatures[0].damping)
        amplitude.append(amplitude[-1] * np.exp(-0.5 * STEP * (VISCOUS + strength * c_eq)))
    time = STEP * np.arange(len(amplitude))
    random = np.random.default_rng(seed)
    read = np.array(amplitude) * np.exp(scatter * random.standard_normal(len(time)))
    return DecayCurve(time, read, FREQUENCY * time, 0 * time, 0 * time)


def search(strength: float, scatter: float, seed: int = 0) -> SimpleNamespace:
    """Return what `leaders` needs of a search: three releases of quadratic damping, cubic damping beside it."""
    grid = np.geomspace(1e-4, 0.03, 40)
    terms = (*base_model().forces, *(Term(find_effect(n)) for n in ("quadratic_damping", "cubic_damping")))
    laws = [law_of(term, {}, FREQUENCY, grid, 20.0) for term in terms]
    parts = tuple(curve(laws[3], strength, scatter, 10 * seed + i) for i in range(3))
    return SimpleNamespace(regression=CurveRegression(parts, laws, FREQUENCY), parts=parts, one_record=False)


def led(found: SimpleNamespace) -> Counter:
    """Return how often each of the two laws leaves less than the other."""
    rows = found.regression.measured
    contenders = [Contender(c, (0, 1, 2, c), rows) for c in (3, 4)]
    before = Contender(-1, (0, 1, 2), rows)
    return Counter(
        leaders(found, contenders, before, "envelope", lambda left, usual: min(left, key=left.get))
    )


def test_a_law_that_is_there_leads_in_every_drawing():
    assert led(search(strength=8.0, scatter=1e-4))[3] == RESAMPLINGS


def test_what_a_law_makes_exactly_is_found_whichever_cycles_are_drawn():
    regression = search(strength=8.0, scatter=0.0).regression
    exact = [
        regression.rows_by(part, (0, 1, 2, 3), np.array([FREQUENCY**2, 0.01, VISCOUS, 8.0]))
        for part in regression.curves
    ]
    random = np.random.default_rng(3)
    counts = [random.integers(0, 3, len(part)).astype(float) for part in regression.curves]
    found = drawn(regression, (0, 1, 2, 3), [exact], counts).solve(
        (0, 1, 2, 3), [0, 1, 2], exact, one_record=True
    )
    assert found.shared == pytest.approx([FREQUENCY**2, 0.01, VISCOUS, 8.0], rel=1e-4)


def test_an_error_counts_the_cycles_that_were_drawn():
    """Of a curve that errs in its first half alone, the second half alone has no error of the envelope."""
    whole = search(strength=8.0, scatter=0.0).regression
    part = whole.curves[0]
    right = whole.rows_by(part, (0, 1, 2, 3), np.array([FREQUENCY**2, 0.0, VISCOUS, 8.0]))
    wrong = right.loss.copy()
    wrong[: len(wrong) // 2] *= 1.2
    rows = type(right)(wrong, right.stiffness, right.centre)
    late = np.where(np.arange(len(part)) > len(wrong) // 2, 1.0, 0.0)
    strengths, columns = np.array([FREQUENCY**2, 0.0, VISCOUS, 8.0]), (0, 1, 2, 3)
    half = drawn(whole, columns, [[rows, *whole.measured[1:]]], [late, late, late])
    assert half.error(strengths, columns, 0, rows).envelope == pytest.approx(0.0, abs=1e-9)
    assert whole.error(strengths, columns, 0, rows).envelope > 1.0
