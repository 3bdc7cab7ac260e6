"""Frames: one session under several models, on axes that stay. What each model leaves, over the cycle and over time."""

import hashlib
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.multiple_shooting import shoot
from identify.comparison.residual_force import estimate_extra_force
from identify.fitting.fit import Fit
from identify.fitting.problem import Problem
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.models import ModelFile
from station.text.numbers import scale, typeset
from station.workbench import view_models
from station.workbench.build_view_models import EYE, MOST_POINTS, for_eye, numbers

RINGS, SECTORS = 10, 32
FEWEST = 4
"""Samples in a cell, on the average, below which the cells are made larger."""

UNKNOWN = 8.0
"""Times the median standard error above which nothing is known of a cell."""

Places = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Cells:
    """A partition of the samples: the code of each cell that is visited, and in which of them each sample lies."""

    codes: Places
    member: Places

    @property
    def patterns(self) -> NDArray[np.float64]:
        """A constant force in each cell, shape (samples, cells)."""
        return np.asarray(self.member[:, None] == np.arange(len(self.codes)), dtype=float)


@dataclass(frozen=True, eq=False)
class Ground:
    """What all frames of a session stand on: its release, the cells of the map, and the units that people read."""

    prepared: PreparedDecay
    stage: view_models.Stage
    cycle: Cells
    force_scale: float


def frame_id(model: ModelFile) -> str:
    """Return the name of a model's frame: the same model with the same values has the same."""
    return hashlib.sha256(model.model_dump_json().encode()).hexdigest()[:16]


def ground_of(prepared: PreparedDecay, fit: Fit, mass: float | None) -> Ground:
    """Return the axes and cells of a session; `fit` gives its window. They depend on the release alone, not on a model."""
    window, motion = fit.windows[0], prepared.motion
    units = DiscrepancyText(window.unit, mass)
    frequency = prepared.frequency
    u, w = motion.displacement, motion.velocity / frequency
    size, angle = np.hypot(u, w), np.mod(np.arctan2(-w, u), 2.0 * np.pi)
    coarse = min(1.0, math.sqrt(len(u) / (FEWEST * RINGS * SECTORS)))
    rings, sectors = (
        max(4, round(RINGS * coarse)),
        4 * max(3, round(SECTORS * coarse / 4)),
    )  # reversals are edges
    amplitude = np.linspace(0.0, float(np.nanmax(size)) * (1.0 + 1e-9), rings + 1)
    phase = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    cycle = _cells(size, amplitude, angle, phase)
    factor, unit = scale("displacement", window.unit)
    step = max(1, math.ceil(len(window) / MOST_POINTS))
    stage = view_models.Stage(
        time=numbers(window.clock[::step], 1e-5),
        velocity_per_amplitude=frequency / factor,
        units={"u": unit, "v": f"{window.unit}/s", "f": typeset(units.force_unit)},
        traces=tuple(_trace(fit, channel, step) for channel in window.channels),
        cycle=view_models.MapAxes(for_eye(amplitude * factor), for_eye(phase), cycle.codes.tolist()),
    )
    return Ground(prepared, stage, cycle, units.force_scale)


def _cells(
    first: NDArray[np.float64], first_edges: NDArray[np.float64],
    second: NDArray[np.float64], second_edges: NDArray[np.float64],
) -> Cells:  # fmt: skip
    rows, columns = len(first_edges) - 1, len(second_edges) - 1
    row = np.clip(np.searchsorted(first_edges, first, side="right") - 1, 0, rows - 1)
    column = np.clip(np.searchsorted(second_edges, second, side="right") - 1, 0, columns - 1)
    codes, member = np.unique(row * columns + column, return_inverse=True)
    return Cells(codes, member)


def _trace(fit: Fit, channel: str, step: int) -> view_models.Measured:
    window = fit.windows[0]
    factor, unit = scale(channel, window.unit)
    fine, fine_unit = scale(channel, window.unit, fine=True)
    hole = _holes(fit, channel)
    measured = np.where(hole, np.nan, window.readings[channel]) * factor
    quantum = _quantum(fit, channel)
    return view_models.Measured(
        channel,
        typeset(unit),
        typeset(fine_unit),
        numbers(measured[::step], quantum),
        float(f"{window.sigma[channel] * fine:.4g}"),
        fine / factor,
    )


def _holes(fit: Fit, channel: str) -> NDArray[np.bool_]:
    window = fit.windows[0]
    hole = ~window.used[channel]
    hole[: window.lead] = False
    return hole


def _quantum(fit: Fit, channel: str) -> float:
    window = fit.windows[0]
    factor, _ = scale(channel, window.unit)
    largest = float(np.nanmax(np.abs(window.readings[channel]))) * factor
    return min(largest / EYE / 10, window.sigma[channel] * factor / 2)


def frame_of(ground: Ground, fit: Fit) -> view_models.Frame:
    """Work out what a fitted model leaves: its motion, each channel's residual, the force that it lacks in each cell.

    The force is estimated as `identify.comparison` does it: the model is run afresh every cycle, and a constant force in
    each cell takes up the residual; so its standard error is that of the readings' noise.
    """
    shooting = shoot(*without_faults(ground.prepared, fit))
    found = estimate_extra_force(shooting, ground.cycle.patterns)
    known = found.std < UNKNOWN * np.median(found.std)
    cycle, cycle_std = (np.where(known, one * ground.force_scale, np.nan) for one in (found.size, found.std))
    return view_models.Frame(*motion_of(fit), _four(cycle), _four(cycle_std))


def without_faults(prepared: PreparedDecay, fit: Fit) -> tuple[PreparedDecay, Fit]:
    """Return a release and its fit, corrected for the sensors' faults in the model, which then has forces alone.

    A fault would be taken for a force otherwise: the residual of a reading is laid to the motion.
    """
    faults = [term.effect.name for term in fit.model.terms if not term.is_force]
    if not faults:
        return prepared, fit
    model, window, motion = fit.model, fit.windows[0], prepared.motion
    for name in faults:
        model = model.minus(name)
    clean = Problem(model, fit.windows[:1], fit.frequency)
    theta = clean.theta(fit.of_release(0))
    seen = clean.read(theta, 0, clean.respond(theta, 0))
    error = {c: fit.predicted[0][c] - seen[c] for c in window.channels}
    readings = {c: window.readings[c] - error[c] for c in window.channels}
    moved = {c: getattr(motion, c) - error[c] for c in ("displacement", "velocity") if c in error}
    right = replace(prepared, motion=replace(motion, **moved))
    return right, replace(fit, model=model, windows=(window.with_(readings=readings),))


def motion_of(fit: Fit) -> tuple[tuple[view_models.Numbers, ...], tuple[view_models.Numbers, ...]]:
    """Take the model's readings and the residual, channel by channel, in the units of the stage."""
    window = fit.windows[0]
    step = max(1, math.ceil(len(window) / MOST_POINTS))
    models, lefts = [], []
    for channel in window.channels:
        factor, _ = scale(channel, window.unit)
        fine, _ = scale(channel, window.unit, fine=True)
        left = np.where(_holes(fit, channel), np.nan, fit.residual(channel)) * fine
        sigma = float(window.sigma[channel] * fine)
        models.append(numbers(fit.predicted[0][channel][::step] * factor, _quantum(fit, channel)))
        lefts.append(numbers(left[::step], max(sigma / 10, float(np.nanmax(np.abs(left))) / EYE)))
    return tuple(models), tuple(lefts)


def _four(values: NDArray[np.float64]) -> view_models.Numbers:
    return [float(f"{value:.4g}") if math.isfinite(value) else None for value in values.tolist()]
