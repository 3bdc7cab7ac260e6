"""Frames: one session under several models, on axes that stay. What each model leaves, over the cycle and over time."""

import hashlib
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identify.arrays import Array
from identify.comparison.compare import without_faults
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.multiple_shooting import shoot
from identify.comparison.residual_force import estimate_extra_force
from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.models import ModelFile
from station.text.numbers import scale, typeset
from station.workbench.view_models import Drawing, Numbers

MOST_POINTS = 3000
FINE = 20_000
"""Steps over the largest value, of which a screen shows one in ten."""

RINGS, SECTORS = 10, 32
FEWEST = 4
"""Samples in a cell, on the average, below which the cells are made larger."""

ALONE = 0.4
"""Share of rings and sectors for one channel, which hardly tells the forces of neighbouring cells apart."""

UNKNOWN = 8.0
"""Times the median standard error above which nothing is known of a cell."""


@dataclass(frozen=True, eq=False)
class Ground:
    """What all frames of a session stand on: its release, its `stage`, and the unit of forces that people read.

    `member` says in which of the visited cells of the map each sample lies.
    """

    prepared: PreparedDecay
    stage: Drawing
    member: NDArray[np.intp]
    force_scale: float


def numbers(values: Array, steps: float = FINE) -> Numbers:
    """Round values to decimals of which the largest has so many steps or more; None where they are not finite."""
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    places = max(0, math.ceil(math.log10(steps / largest))) if largest > 0 else 0
    return [value if math.isfinite(value) else None for value in np.round(values, places).tolist()]


def frame_id(model: ModelFile) -> str:
    """Name a model's frame: the same model with the same values has the same."""
    return hashlib.sha256(model.model_dump_json().encode()).hexdigest()[:16]


def ground_of(prepared: PreparedDecay, fit: Fit) -> Ground:
    """Settle the axes and cells of a session. They depend on the release alone, not on a model; `fit` gives its window.

    The stage holds `time` (s since the release); `traces`, one for each channel: its name, the measured `values` in `unit`,
    and the `fine_unit` of residual and noise; `cycle`, the cells of the map: edges of `rows` (amplitude) and
    `columns` (phase, rad: 0 at the largest displacement, growing with time), and the `cells` that were visited, row *
    columns + column; `velocity_per_amplitude`, the velocity that goes with one unit of amplitude; and the `units` of
    displacement "u", velocity "v" and force "f".
    """
    window, motion = fit.windows[0], prepared.motion
    units, frequency = DiscrepancyText(window.unit, prepared.mass), prepared.frequency
    u, w = motion.displacement, motion.velocity / frequency
    size, angle = np.hypot(u, w), np.mod(np.arctan2(-w, u), 2.0 * np.pi)
    coarse = min(1.0, math.sqrt(len(u) / (FEWEST * RINGS * SECTORS)))
    coarse = coarse if window.paired else min(coarse, ALONE)
    rings, sectors = (
        max(4, round(RINGS * coarse)),
        4 * max(3, round(SECTORS * coarse / 4)),
    )  # reversals are edges
    amplitude = np.linspace(0.0, float(np.nanmax(size)) * (1.0 + 1e-9), rings + 1)
    phase = np.linspace(0.0, 2.0 * np.pi, sectors + 1)
    codes, member = np.unique(_place(size, amplitude) * sectors + _place(angle, phase), return_inverse=True)
    factor, unit = scale("displacement", window.unit)
    stage = {
        "time": numbers(window.clock[:: _stride(fit)], 1e6),
        "velocity_per_amplitude": frequency / factor,
        "units": {"u": unit, "v": f"{window.unit}/s", "f": typeset(units.force_unit)},
        "traces": [_trace(fit, channel) for channel in window.channels],
        "cycle": {
            "rows": numbers(amplitude * factor),
            "columns": numbers(phase),
            "cells": codes.tolist(),
        },
    }
    return Ground(prepared, stage, member, units.force_scale)


def _place(values: Array, edges: Array) -> NDArray[np.intp]:
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)


def _trace(fit: Fit, channel: str) -> Drawing:
    window = fit.windows[0]
    factor, unit = scale(channel, window.unit)
    _, fine_unit = scale(channel, window.unit, fine=True)
    measured = np.where(_holes(fit, channel), np.nan, window.readings[channel]) * factor
    return {
        "channel": channel,
        "unit": typeset(unit),
        "fine_unit": typeset(fine_unit),
        "values": numbers(measured[:: _stride(fit)]),
    }


def _stride(fit: Fit) -> int:
    return max(1, math.ceil(len(fit.windows[0]) / MOST_POINTS))


def _holes(fit: Fit, channel: str) -> NDArray[np.bool_]:
    window = fit.windows[0]
    hole = ~window.used[channel]
    hole[: window.lead] = False
    return hole


def frame_of(ground: Ground, fit: Fit) -> Drawing:
    """Work out what a fitted model leaves: `model`, its readings, `left`, the residual, and `noise`, the standard deviation
    by which it is judged, channel by channel in the units of the stage; `cycle` and `cycle_std`, the force that it lacks in
    each cell and its standard error.

    The force is estimated as `identify.comparison` does it: the model is run afresh every cycle, and a constant force in
    each cell takes up the residual; so its standard error is that of the readings' noise.
    """
    cells = np.arange(len(ground.stage["cycle"]["cells"]))
    patterns = np.asarray(ground.member[:, None] == cells, dtype=float)
    seen = without_faults(ground.prepared, fit) if fit.model.faults else (ground.prepared, fit)
    found = estimate_extra_force(shoot(*seen), patterns)
    usual = float(np.median(found.std))
    force, std = (
        np.where(found.std < UNKNOWN * usual, one * ground.force_scale, np.nan)
        for one in (found.size, found.std)
    )
    window, stride = fit.windows[0], _stride(fit)
    models, lefts, noise = [], [], []
    for channel in window.channels:
        factor, _ = scale(channel, window.unit)
        small, _ = scale(channel, window.unit, fine=True)
        left = np.where(_holes(fit, channel), np.nan, fit.residual(channel)) * small
        models.append(numbers(fit.predicted[0][channel][::stride] * factor))
        lefts.append(numbers(left[::stride]))
        noise.append(float(f"{fit.noise(channel) * small:.4g}"))
    return {
        "model": models,
        "left": lefts,
        "noise": noise,
        "cycle": numbers(force),
        "cycle_std": numbers(std),
    }
