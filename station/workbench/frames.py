"""Frames: one session under several models, on axes that stay. What each model leaves, in the phase plane and over time."""

import math

import numpy as np
from numpy.typing import NDArray

from daq.storage import digest
from identify.arrays import Array
from identify.comparison.compare import without_faults
from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.multiple_shooting import shoot
from identify.comparison.phase_plane import FEWEST, compare_phase_plane
from identify.fitting.fit import Fit
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.models import ModelFile
from station.text.numbers import scale, typeset
from station.workbench.view_models import Drawing, Numbers

MOST_POINTS = 3000
FINE = 20_000
"""Steps over the largest value, of which a screen shows one in ten."""

FINER = 7
"""Samples in a cell of the map where two channels tell the forces of neighbouring cells apart."""


def numbers(values: Array, steps: float = FINE) -> Numbers:
    """Round values to decimals of which the largest has so many steps or more; None where they are not finite."""
    largest = float(np.abs(values[np.isfinite(values)]).max(initial=0.0))
    places = max(0, math.ceil(math.log10(steps / largest))) if largest > 0 else 0
    return [value if math.isfinite(value) else None for value in np.round(values, places).tolist()]


def frame_id(model: ModelFile) -> str:
    """Name a model's frame: the same model with the same values has the same."""
    return digest(model.model_dump_json().encode())[:16]


def stage_of(prepared: PreparedDecay, fit: Fit) -> Drawing:
    """Settle the axes of a session, which depend on the release alone, not on a model; `fit` gives its window.

    The stage holds `time` (s since the release); `traces`, one for each channel: its name, the measured `values` in `unit`,
    and the `fine_unit` of residual and noise; the `units` of displacement "u", velocity "v" and force "f"; the `largest`
    displacement and velocity in them; and the `mass` that the forces of all frames have in them.
    """
    window, motion = fit.windows[0], prepared.motion
    factor, unit = scale("displacement", window.unit)
    force_unit = DiscrepancyText(window.unit, prepared.mass).force_unit
    return {
        "time": numbers(window.clock[:: _stride(fit)], 1e6),
        "units": {"u": unit, "v": f"{window.unit}/s", "f": typeset(force_unit)},
        "traces": [_trace(fit, channel) for channel in window.channels],
        "mass": prepared.mass,
        "largest": {
            "u": float(np.nanmax(np.abs(motion.displacement))) * factor,
            "v": float(np.nanmax(np.abs(motion.velocity))),
        },
    }


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


def frame_of(prepared: PreparedDecay, fit: Fit) -> Drawing:
    """Work out what a fitted model leaves: `model`, its readings, `left`, the residual, and `noise`, the standard deviation
    by which it is judged, channel by channel in the units of the stage; `force` and `force_std`, the force that it lacks in
    each known cell of the phase plane and its standard error; `cells`, the edges of each: displacement, then velocity.

    The map is that of `identify.comparison`, which the words beside it, the report and the tab Curves have too; of two
    channels it is finer, and a sensor's fault in the model is taken off the readings wherever the fit stands.
    """
    seen = without_faults(prepared, fit) if fit.model.faults else (prepared, fit)
    plane = compare_phase_plane(shoot(*seen), FINER if fit.windows[0].paired else FEWEST)
    window, stride = fit.windows[0], _stride(fit)
    row, column = plane.bins.T
    u, v = plane.displacement_edges * scale("displacement", window.unit)[0], plane.velocity_edges
    newtons = DiscrepancyText(window.unit, prepared.mass).force_scale
    models, lefts, noise = [], [], []
    for channel in window.channels:
        factor, _ = scale(channel, window.unit)
        small, _ = scale(channel, window.unit, fine=True)
        left = np.where(_holes(fit, channel), np.nan, fit.left(channel)) * small
        models.append(numbers(fit.predicted[0][channel][::stride] * factor))
        lefts.append(numbers(left[::stride]))
        noise.append(float(f"{fit.noise(channel) * small:.4g}"))
    return {
        "model": models,
        "left": lefts,
        "noise": noise,
        "force": numbers(plane.force[row, column] * newtons),
        "force_std": numbers(plane.std[row, column] * newtons),
        "cells": np.column_stack([u[column], u[column + 1], v[row], v[row + 1]]).tolist(),
    }
