"""The explanation: two sentences that an engineer accepts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.estimate import Estimate
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.fit import Fit

if TYPE_CHECKING:
    from identify.diagnosis.diagnose import Suspect


def explain(
    start: Baseline,
    verdict: str,
    suspects: tuple[Suspect, ...],
    together: tuple[str, ...],
    findings: tuple[CorrectedFault, ...],
    final: Fit,
    shape: NonparametricForce | None,
) -> str:
    """Return why the verdict is what it is, with numbers and the alternatives that remain."""
    floor = f"1.00 +- {start.spread:.2f}"
    before = start.reduced(start.fit)
    if verdict == "nothing_missing":
        first = (
            f"The model leaves a reduced chi-square of {before:.2f}, which is the noise floor ({floor}); no effect of the "
            "library lowers it by more than chance would."
        )
        return f"{first} {_limit(start, suspects)}".strip()
    if verdict == "not_enough_data":
        return (
            "Fewer than five cycles of free motion stand above friction and noise, too few to tell effects apart. "
            "Release from a larger amplitude, or record for longer."
        )
    top = suspects[0] if suspects else None
    if verdict == "unknown_effect" or top is None:
        return _unknown(before, floor, top, final, shape)
    if top.effect.name in {f.term.effect.name for f in findings}:
        return _finding(top, before, floor)
    return _named(top, suspects, together, before, floor, start, final, shape)


def _named(
    top: Suspect,
    suspects: tuple[Suspect, ...],
    together: tuple[str, ...],
    before: float,
    floor: str,
    start: Baseline,
    final: Fit,
    shape: NonparametricForce | None,
) -> str:
    cause = "Missing is" if top.kind == "physics" else "A sensor is at fault:"
    where = f" in the {top.term.channel} channel" if top.term.channel else ""
    numbers = ", ".join(f"{name} = {_number(value)}" for name, value in top.parameters.items())
    first = f"{cause} {top.effect.title}{where} ({top.effect.name}: {numbers})"
    if together:
        first += f" together with {' and '.join(together)}: both reach {final.reduced:.2f}"
    else:
        first += f": it lowers the reduced chi-square from {_size(before)} to {_size(top.error_after)}"
    first += f", the noise floor being {floor}."
    others = [s for s in suspects[1:] if s.kind == top.kind or s.p_value < 0.05]
    close = [
        n
        for n in top.confusable_with
        if any(s.effect.name == n and top.evidence - s.evidence < 4.6 for s in suspects)
    ]
    if close:
        second = f"This record does not tell it from {', '.join(close)}."
    elif others and others[0].p_value < 0.05:
        rival = f"{others[0].effect.name}, leaves {_size(others[0].error_after)}"
        second = f"The next best, {rival}; the sign of the first is: {top.effect.symptom}."
    else:
        second = f"No other effect explains it; its sign is: {top.effect.symptom}."
    if shape is not None and not start.adequate(final):
        rest = f"{_size(final.reduced)} times the noise"
        second += f" What remains ({rest}) follows no force in displacement, velocity or time."
    return f"{first} {second}"


def _unknown(
    before: float, floor: str, top: Suspect | None, final: Fit, shape: NonparametricForce | None
) -> str:
    first = f"Something is missing that the library does not name: the model leaves {_size(before)} times the noise"
    if top is not None and top.p_value < 0.05:
        first += f", and the best named effect, {top.effect.name}, still {_size(top.error_after)}"
    first += f", where the floor is {floor}."
    if shape is None or not shape.coordinates:
        return f"{first} No smooth force in displacement, velocity or time explains it either."
    peak = shape.shapes[0]
    at = int(np.argmax(np.abs(peak.force)))
    return (
        f"{first} A free-form force explains {100.0 * shape.explained:.0f} % of the rest; it depends on "
        f"{' and '.join(shape.coordinates)} and is largest near {peak.position[at]:.3g} {peak.unit} "
        f"({peak.force[at]:+.2g} {_unit_of_force(peak.unit)})."
    )


def _unit_of_force(unit: str) -> str:
    return "per unit mass" if unit else ""


def _finding(top: Suspect, before: float, floor: str) -> str:
    numbers = ", ".join(f"{name} = {_number(value)}" for name, value in top.parameters.items())
    where = f" in the {top.term.channel} channel" if top.term.channel else ""
    return (
        f"A sensor is at fault: {top.effect.title}{where} ({top.effect.name}: {numbers}); without allowing for it the "
        f"reduced chi-square is {_size(before)}, with it {_size(top.error_after)}, the floor being {floor}. "
        f"The forces are not affected once it is corrected; {top.effect.confirming_test}."
    )


def _limit(start: Baseline, suspects: tuple[Suspect, ...]) -> str:
    detail = [s for s in suspects if s.effect.shows_detection_limit and s.fit is not None]
    words = []
    for suspect in detail:
        strength = suspect.parameters.get(suspect.effect.strength.name)
        if strength is not None and np.isfinite(strength.std):
            words.append(f"{suspect.effect.name} beyond +-{3.0 * strength.std:.2g} {strength.unit}")
    return f"It would have shown {' or '.join(words)}." if words else ""


def _number(value: Estimate) -> str:
    unit = "" if value.unit == "1" else f" {value.unit}"
    if not np.isfinite(value.std) or value.std == 0.0:
        return f"{value.value:.4g}{unit}"
    digits = max(0, min(6, int(np.floor(np.log10(max(abs(value.value), 1e-300) / value.std))) + 2))
    return f"{value.value:.{max(digits, 2)}g} +- {value.std:.1g}{unit}"


def _size(value: float) -> str:
    return f"{value:.2f}" if value < 10.0 else f"{value:.0f}"
