"""A law fitted to the curves alone: what a model, or an effect in place of another, would make of them."""

from collections.abc import Sequence

import numpy as np

from identify.arrays import Array
from identify.curves.averaged_law import AveragedLaw, amplitude_grid, inner_of, law_of, laws_of, values_of
from identify.curves.curve_regression import CurveRegression, Rows
from identify.curves.laid_over import Isolated, Law, Role, isolated
from identify.curves.simulated_curve import simulated_curve
from identify.errors import NotIdentifiable
from identify.fitting.initial_values import scales_of
from identify.free_decay import FreeDecay
from identify.model.model import Model, Term, base_model
from identify.preprocessing.prepared_decay import PreparedDecay

_ROUNDS = 2

Decays = FreeDecay | PreparedDecay | Sequence[FreeDecay | PreparedDecay]


def usual_law(decays: Decays, model: Model | None = None, values: dict[str, float] | None = None) -> Law:
    """Return a model with the strengths that the curves of some releases ask for: the best that its law can do.

    The model is stiffness, dry and viscous friction unless given; `values` has its inner parameters by unknown's name.
    Raises NotIdentifiable where no release has a curve.
    """
    return _fitted(isolated(decays), model or base_model(), values or {}, None, "usual model", "usual")


def rival_law(decays: Decays, law: Law, effect: str, rival: Term, role: Role = "rival") -> Law | None:
    """Return a law with another effect in place of one of its own, all strengths fitted to the curves.

    The inner parameters of the other effects are kept; those of the rival are the best of its starting values. None
    where the rival has no law of amplitude.
    """
    model = law.model.minus(effect) if effect in law.model else law.model
    try:
        return _fitted(isolated(decays), model, law.values, rival, rival.effect.name, role)
    except NotIdentifiable:
        return None


def _fitted(
    found: tuple[Isolated, ...],
    model: Model,
    values: dict[str, float],
    last: Term | None,
    name: str,
    role: Role,
) -> Law:
    laws, starts = _laws(found, model, values, last)
    frequency = _mean_frequency(found)
    regression = CurveRegression([one.curve for one in found], laws, frequency)
    base = tuple(range(len(laws) - len(starts)))
    choices = [(*base, len(base) + i) for i in range(len(starts))] or [base]
    rows: Sequence[Rows] = regression.measured
    best: tuple[float, tuple[int, ...], Array] | None = None
    for turn in range(1 + _ROUNDS):
        ends = [_end(regression, columns, rows) for columns in choices]
        best = min(ends, key=lambda end: end[0])
        if turn < _ROUNDS:
            chosen = [laws[c] for c in best[1]]
            rows = _corrected(found, regression, best[1], chosen, best[2])
    assert best is not None
    chosen = [laws[c] for c in best[1]]
    return Law(name, role, Model(tuple(one.term for one in chosen)), values_of(chosen, best[2]))


def _laws(
    found: tuple[Isolated, ...], model: Model, values: dict[str, float], last: Term | None
) -> tuple[tuple[AveragedLaw, ...], tuple[AveragedLaw, ...]]:
    """Return the laws of a model with those of one more effect at all starts behind, and the latter alone."""
    frequency = _mean_frequency(found)
    duration = max(float(one.curve.time[-1]) for one in found)
    grid = amplitude_grid(one.curve for one in found)
    base = tuple(law_of(term, inner_of(term, values), frequency, grid, duration) for term in model.forces)
    if last is None:
        return base, ()
    largest = max(found, key=lambda one: one.decay.amplitude)
    starts = laws_of((last,), frequency, scales_of(largest.decay, {}), grid, duration)
    if not starts:
        raise NotIdentifiable(f"{last.effect.name} has no law of amplitude.")
    return (*base, *starts), starts


def _mean_frequency(found: tuple[Isolated, ...]) -> float:
    return float(np.median(np.concatenate([one.curve.frequency for one in found])))


def _end(
    regression: CurveRegression, columns: tuple[int, ...], rows: Sequence[Rows]
) -> tuple[float, tuple[int, ...], Array]:
    releases = range(len(regression.curves))
    strengths = regression.solve(columns, releases, rows)
    errors = [regression.error(strengths.of(i), columns, i, rows[i]).motion for i in releases]
    return float(np.sum(np.square(errors))), columns, strengths.shared


def _corrected(
    found: tuple[Isolated, ...],
    regression: CurveRegression,
    columns: tuple[int, ...],
    laws: Sequence[AveragedLaw],
    strengths: Array,
) -> tuple[Rows, ...]:
    """Return what was measured, less what the windows and the averaging do to a motion of these laws."""
    model, values = Model(tuple(law.term for law in laws)), values_of(laws, strengths)
    rows = []
    for measured, one in zip(regression.measured, found, strict=True):
        run = simulated_curve(one.decay, one.mode, model, values, one.curve)
        excess = None if run is None else regression.excess(run, columns, strengths)
        rows.append(measured if excess is None else measured.minus(excess))
    return tuple(rows)
