"""From a comparison to what the page draws: units that people read, and digits that the eye can see."""

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identify.comparison.discrepancy_text import DiscrepancyText
from identify.comparison.phase_plane import ForceSection
from identify.effects.library import LIBRARY
from station.results import diagnosis_document
from station.results.ladder import LADDER, KeptLadder
from station.results.models import parsed_effect
from station.story.compared import Compared
from station.text.numbers import energy_scale, scale, typeset
from station.workbench import view_models

MOST_POINTS = 3000
EYE = 2000
MOST_PLACES = 3

Array = NDArray[np.float64]


def picture_of(compared: Compared) -> view_models.Picture:
    """Make the picture that the tab Curves draws."""
    found, error = compared.comparison, compared.error
    units = DiscrepancyText(found.unit, found.mass)
    step = max(1, math.ceil(len(found.time) / MOST_POINTS))
    factor, unit = scale("displacement", found.unit)
    return view_models.Picture(
        time=numbers(found.time[::step], 1e-5),
        displacement_unit=unit,
        velocity_unit=f"{found.unit}/s",
        force_unit=typeset(units.force_unit),
        plane=_plane(compared, factor, units.force_scale),
        cycles=_cycles(compared, units),
        errors={
            "motion_percent": error.motion_percent,
            "chi2": error.chi_square,
            "chi2_std": error.floor_std,
            "horizon_s": error.horizon_s,
            "cycles": error.horizon_s * compared.baseline.fit.frequency / (2.0 * math.pi),
        },
        summary=found.summary,
        words=compared.words,
        cause=" ".join(filter(None, (found.cause, compared.one_run))),
        places=tuple(place.text for place in found.places[:MOST_PLACES]),
    )


def _plane(compared: Compared, factor: float, force_scale: float) -> view_models.Plane:
    plane = compared.comparison.phase_plane
    down, up = plane.sections_at_reversal
    return view_models.Plane(
        _section("u = 0", plane.section_at_middle, 1.0, force_scale),
        (_section("v < 0", down, factor, force_scale), _section("v > 0", up, factor, force_scale)),
    )


def _section(name: str, section: ForceSection, factor: float, force_scale: float) -> view_models.Section:
    return view_models.Section(
        name,
        for_eye(section.position * factor),
        for_eye(section.force * force_scale),
        for_eye(section.std * force_scale),
    )


def _cycles(compared: Compared, units: DiscrepancyText) -> view_models.Cycles:
    found = compared.comparison.cycles
    factor, energy = energy_scale(units)
    return view_models.Cycles(
        for_eye(found.time),
        for_eye(found.frequency_error),
        for_eye(found.frequency_error_std),
        for_eye(found.energy_error * factor),
        for_eye(found.energy_error_std * factor),
        typeset(energy),
    )


def numbers(values: Array, quantum: float) -> view_models.Numbers:
    """Return values rounded to a decimal place below `quantum`, None where they are not finite."""
    places = 0 if quantum <= 0 or not math.isfinite(quantum) else max(0, -math.floor(math.log10(quantum)))
    return [round(value, places) if math.isfinite(value) else None for value in values.tolist()]


def for_eye(values: Array) -> view_models.Numbers:
    """Return values rounded to what can be seen on a screen: a few thousandths of the largest."""
    finite = values[np.isfinite(values)]
    return numbers(values, float(np.max(np.abs(finite), initial=0.0)) / EYE)


def equations_of(ladder: KeptLadder) -> dict[str, str]:
    """Return the equations of the effects of the library, and of the user's own in the ladder, by the effect's name."""
    own = dict.fromkeys(text for step in ladder.steps for text in step.model.expressions)
    effects = (*LIBRARY, *(parsed_effect(text) for text in own))
    return {effect.name: typeset(effect.equation) for effect in effects}


def results_stamp(folder: Path) -> tuple[int, ...]:
    """Read a stamp that changes when a command, or another tab, has written results."""
    stamp = []
    for name in (LADDER, diagnosis_document.NAME):
        try:
            stamp.append((folder / "results" / name).stat().st_mtime_ns)
        except OSError:
            stamp.append(0)
    return tuple(stamp)
