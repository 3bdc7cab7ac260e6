"""The free form: how much a smooth force of displacement, velocity and time explains, without a name.

The acceleration's misfit is regressed on smooth splines of displacement and velocity, of friction over displacement and
speed, and of slow changes of stiffness, damping and friction with time. Compared with what the named effects
explain, it tells whether something is missing that the library does not know, and what it looks like.
"""

from dataclasses import dataclass, replace

import numpy as np

from identify.arrays import Array, Mask, frozen
from identify.effects.force_effect import ForceEffect
from identify.effects.user.measured_curve import COUNT, CurveForm, curve_effect
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, force_along_motion
from identify.fitting.fit import Fit
from identify.preprocessing.equation_error import moving
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.signal.splines import DEGREE, basis

_FORMS = {
    "displacement": (CurveForm("", "u", 0.0, 1.0, 1), 24),
    "velocity": (CurveForm("", "v", 0.0, 1.0, 1), 16),
    "friction over displacement": (CurveForm("sgn(v)", "u", 0.0, 1.0, 1), 14),
    "friction over speed": (CurveForm("sgn(v)", "abs(v)", 0.0, 1.0, 1), 12),
    "time (stiffness)": (CurveForm("u", "t", 0.0, 1.0, 1), 6),
    "time (damping)": (CurveForm("v", "t", 0.0, 1.0, 1), 6),
    "time (friction)": (CurveForm("sgn(v)", "t", 0.0, 1.0, 1), 6),
}
"""The coordinates: the form of a curve over each, whose ends and unit are open here, and the knots of its spline."""

_STIFFNESSES = (1e-4, 1e-2, 1.0)
_MOST_COORDINATES = 3


@dataclass(frozen=True, eq=False)
class Shape:
    """The missing force per unit mass along one coordinate: positions, force and its standard error, shape (m,).

    A change of stiffness or damping with time is given as its force at the largest displacement or velocity, `at`.
    """

    coordinate: str
    unit: str
    position: Array
    force: Array
    std: Array
    at: float = 1.0
    at_unit: str = ""

    @property
    def where(self) -> str:
        """The displacement or velocity that the force belongs to, in words; "" where it is all the force there."""
        return f"at {self.at:.2g} {self.at_unit}" if self.at_unit else ""


_FEWEST_HELD = 60
"""Readings of every other cycle, well above the noise in their velocity, that a free form asks for."""


@dataclass(frozen=True, eq=False)
class NonparametricForce:
    """The part of a model's misfit in the acceleration that the free form explains.

    `before` and `after` are the misfit's mean squares in units of the noise, on readings held out by whole cycles;
    `shapes` the missing force along each coordinate, the one that explains most first; `coordinates` those that the
    held-out cycles confirm.
    """

    before: float
    after: float
    shapes: tuple[Shape, ...]
    coordinates: tuple[str, ...] = ()

    @property
    def explained(self) -> float:
        """Share of the misfit beyond the noise that the free form explains, 0 to 1."""
        beyond = self.before - 1.0
        return (
            float(np.clip((self.before - max(self.after, 1.0)) / beyond, 0.0, 1.0)) if beyond > 0.0 else 0.0
        )


def nonparametric_force(prepared: PreparedDecay, force: Array) -> NonparametricForce:
    """Explain what a model's force, shape (n,) along the setting's motion (m/s^2), leaves of the acceleration.

    Coordinates are added one after the other while they lower the misfit on the cycles held out.
    """
    motion = prepared.motion
    used = moving(motion, sigmas=4.0)
    misfit = prepared.restoring - force
    noise = max(motion.noise_acceleration or 0.0, 1e-300)
    cycle = np.floor(prepared.time * prepared.frequency / (2.0 * np.pi)).astype(int)
    folds = [used & (cycle % 2 == parity) for parity in (0, 1)]
    if min(int(fold.sum()) for fold in folds) < _FEWEST_HELD:
        return NonparametricForce(1.0, 1.0, ())
    inside = [_within(prepared, used & ~fold, fold) for fold in folds]
    if not all(mask.any() for mask in inside):
        return NonparametricForce(1.0, 1.0, ())
    blocks = _blocks(prepared)
    chosen: list[str] = []
    best = before = _held_out([], misfit, folds, inside)
    while len(chosen) < _MOST_COORDINATES:
        trials = {
            name: _held_out([blocks[c] for c in (*chosen, name)], misfit, folds, inside)
            for name in blocks
            if name not in chosen
        }
        name = min(trials, key=lambda key: trials[key])
        if trials[name] > 0.9 * best:
            break
        best = trials[name]
        chosen.append(name)
    shapes = _shapes(prepared, blocks, misfit, used)
    shapes = tuple(sorted(shapes, key=lambda s: chosen.index(s.coordinate) if s.coordinate in chosen else 99))
    return NonparametricForce(before / noise**2, best / noise**2, shapes, tuple(chosen))


def free_form(baseline: Baseline, found: Fit) -> NonparametricForce:
    """Fit the free form to the residual of a fit, along the release of the largest amplitude."""
    place = baseline.decays.index(baseline.largest)
    return nonparametric_force(baseline.largest, force_along_motion(baseline.largest, found, place))


def _within(prepared: PreparedDecay, fitted: Mask, held: Mask) -> Mask:
    """Select the held-out readings inside the range of the fitted ones, so that nothing is extrapolated."""
    motion = prepared.motion
    mask = held.copy()
    for values in (motion.displacement, motion.velocity, prepared.time):
        mask &= (values >= values[fitted].min()) & (values <= values[fitted].max())
    return mask


def _held_out(blocks: list[Array], misfit: Array, folds: list[Mask], inside: list[Mask]) -> float:
    """Return the mean squared misfit on held-out cycles at the best smoothness."""
    results = []
    for stiffness in _STIFFNESSES if blocks else (1.0,):
        total, count = 0.0, 0
        for fitted, mask in zip(reversed(folds), inside, strict=True):
            total += float(np.sum((misfit - _smooth(blocks, misfit, fitted, stiffness))[mask] ** 2))
            count += int(mask.sum())
        results.append(total / count)
    return min(results)


def _smooth(blocks: list[Array], misfit: Array, used: Mask, stiffness: float) -> Array:
    """Fit a constant and penalised splines to the used part of the misfit, (n,) (Eilers and Marx 1996).

    Second differences of the coefficients of each block are kept small.
    """
    columns = np.column_stack([np.ones(len(misfit)), *blocks])
    fitted = columns[used]
    normal, place = fitted.T @ fitted, 1
    for block in blocks:
        m = block.shape[1]
        bend = np.diff(np.eye(m), 2, axis=0)
        size = float(np.trace(normal[place : place + m, place : place + m])) / m
        normal[place : place + m, place : place + m] += size * (stiffness * bend.T @ bend + 1e-8 * np.eye(m))
        place += m
    rounding = 1e-12 * np.trace(normal) * np.eye(place)
    return np.asarray(columns @ np.linalg.solve(normal + rounding, fitted.T @ misfit[used]))


def coordinates(time: Array, u: Array, v: Array) -> dict[str, tuple[Array, Array]]:
    """Return the position on each coordinate along a motion, and the factor of a curve over it, (n,) each."""
    return {name: (form.position(time, u, v), form.multiplied(u, v)) for name, (form, _) in _FORMS.items()}


def _coordinates(prepared: PreparedDecay) -> dict[str, tuple[Array, Array]]:
    return coordinates(prepared.time, prepared.motion.displacement, prepared.motion.velocity)


def _blocks(prepared: PreparedDecay) -> dict[str, Array]:
    return {
        name: _splines(position, _FORMS[name][1]) * factor[:, None]
        for name, (position, factor) in _coordinates(prepared).items()
    }


def _splines(position: Array, count: int) -> Array:
    first, values = basis(position, float(position.min()), float(position.max()), count - DEGREE)
    design = np.zeros((len(position), count))
    np.put_along_axis(design, first[:, None] + np.arange(values.shape[1]), values, axis=1)
    return design


def _shapes(
    prepared: PreparedDecay, blocks: dict[str, Array], misfit: Array, used: Mask
) -> tuple[Shape, ...]:
    """Regress the misfit on each coordinate alone, the one that explains most first."""
    ranked = []
    target = misfit - misfit[used].mean()
    for name, (position, factor) in _coordinates(prepared).items():
        left = float(np.sum((target - _smooth([blocks[name]], target, used, 1e-2))[used] ** 2))
        edges = np.linspace(position[used].min(), position[used].max(), 41)
        middle = 0.5 * (edges[1:] + edges[:-1])
        bins = np.clip(np.digitize(position[used], edges) - 1, 0, 39)
        at = float(np.max(np.abs(factor[used])))
        share = factor[used] / at
        weight = np.maximum(np.bincount(bins, weights=share**2, minlength=40), 1e-9)
        force = np.bincount(bins, weights=target[used] * share, minlength=40) / weight
        square = np.bincount(bins, weights=(target[used] - force[bins] * share) ** 2, minlength=40)
        std = np.sqrt(square / np.maximum(np.bincount(bins, minlength=40), 1) / weight)
        form, _ = _FORMS[name]
        units = {"t": "s", "u": prepared.window.unit, "v": f"{prepared.window.unit}/s"}
        unit, at_unit = units[form.over.removeprefix("abs(")[0]], units.get(form.factor, "")
        ranked.append((left, Shape(name, unit, frozen(middle), frozen(force), frozen(std), at, at_unit)))
    return tuple(shape for _, shape in sorted(ranked, key=lambda entry: entry[0]))


_LEAST = 1e-3
"""Smallest share of a coefficient of the largest, below which its ratio would have no meaning."""


def curve_of_rest(baseline: Baseline, name: str) -> tuple[ForceEffect, str]:
    """Make an effect called `name` of the force that a fitted model lacks, and the line that saves it.

    The coordinate is the one that explains most of cycles that were held out. The curve covers the whole range of the
    motion, rounded as it is saved, and begins at a regression of the missing force on the release of the largest
    amplitude. Raises NotIdentifiable where no smooth curve explains any.
    """
    shape = free_form(baseline, baseline.fit)
    if not shape.shapes or not shape.coordinates:
        raise NotIdentifiable(
            "the residual follows no curve in displacement, velocity or time, so there is none to add"
        )
    prepared = baseline.largest
    motion = prepared.motion
    form, _ = _FORMS[shape.coordinates[0]]
    position = form.position(prepared.time, motion.displacement, motion.velocity)
    low, high = (float(f"{edge:.6g}") for edge in (np.min(position), np.max(position)))
    form = replace(form, low=0.0 if form.over == "abs(v)" else low, high=high)
    modelled = force_along_motion(prepared, baseline.fit, baseline.decays.index(prepared))
    weights = _regressed(prepared, prepared.restoring - modelled, form)
    largest = int(np.argmax(np.abs(weights)))
    form = replace(form, unit=largest + 1)
    ratios = tuple(float(weights[i] / weights[largest]) for i in range(COUNT) if i != largest)
    return curve_effect(name, form, ratios), f"{name} = {form.formula}"


def _regressed(prepared: PreparedDecay, force: Array, form: CurveForm) -> Array:
    """Fit the six coefficients of a curve to a force along the motion, together with spring and friction."""
    motion = prepared.motion
    columns = form.along(prepared.time, motion.displacement, motion.velocity)
    usual = np.column_stack(
        [motion.displacement, motion.velocity, np.sign(motion.velocity), np.ones(len(force))]
    )
    used = moving(motion)
    design = np.column_stack([columns, usual])[used]
    size = np.maximum(np.linalg.norm(design, axis=0), 1e-300)
    weights = np.linalg.lstsq(design / size, force[used], rcond=1e-9)[0][:COUNT] / size[:COUNT]
    return np.asarray(np.where(np.abs(weights) < _LEAST * np.abs(weights).max(), 0.0, weights))
