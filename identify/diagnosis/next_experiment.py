"""The next experiment: the recording that would separate the two best suspects most."""

from dataclasses import replace

import numpy as np

from identify.arrays import Array
from identify.diagnosis.suspect import Suspect
from identify.fitting.baseline import Baseline
from identify.fitting.fit import Fit, fit
from identify.fitting.problem import Problem
from identify.formatting import plain_name
from identify.model.parameter_id import nuisance
from identify.preprocessing.fit_window import FitWindow

_RELEASES = (
    (0.25, "a release from a quarter of the amplitude"),
    (0.5, "a release from half the amplitude"),
    (-1.0, "a release from the same amplitude on the opposite side"),
    (1.5, "a release from one and a half times the amplitude"),
)
_DRIVES = (
    (0.25, "the motion under the same force at a quarter of its level"),
    (0.5, "the motion under the same force at half its level"),
    (1.5, "the motion under the same force at one and a half times its level"),
)
_WORTH = 25.0
_BY_FAR = 1e6  # of chi-square; also where the rival's motion runs away


def next_experiment(baseline: Baseline, verdict: str, suspects: tuple[Suspect, ...]) -> str:
    """Return what to record next, in a sentence; simulated where two suspects compete."""
    rivals = [s for s in suspects if s.kind == "physics" and s.fit is not baseline.fit]
    amplitude, unit = _amplitude(baseline)
    driven = baseline.decays[0].window.force is not None
    if verdict == "nothing_missing" and driven:
        return "The same force at half and at one and a half times its level would show effects that hide at this one."
    if verdict == "nothing_missing":
        return (
            f"A release from {1.5 * amplitude:.3g} {unit} would show effects that grow with amplitude; "
            f"one from {0.25 * amplitude:.3g} {unit} effects of friction and play."
        )
    if verdict == "not_enough_data":
        return "Record at least eight seconds or ten cycles, from the largest amplitude that is safe."
    if verdict == "driven":
        return f"Stop the drive and release the mass from {amplitude:.3g} {unit}."
    if verdict == "sensor_fault":
        confirming_test = suspects[0].effect.confirming_test
        return f"{confirming_test[0].upper()}{confirming_test[1:]}."
    if verdict == "unknown_effect" or len(rivals) < 2 or len(baseline.decays) > 1:
        if verdict == "missing_effect":
            confirming_test = suspects[0].effect.confirming_test
            return f"To prove it: {confirming_test}."
        if driven:
            return "Drive it at half and at twice the level: the shape of the missing force must be the same in each."
        return (
            f"Release from {0.5 * amplitude:.3g} {unit} and from {-amplitude:.3g} {unit}, and diagnose these together "
            "with what there is: the shape of the missing force must be the same in each."
        )
    first, second = rivals[0], rivals[1]
    one, other = plain_name(first.effect.name), plain_name(second.effect.name)
    best, words = 0.0, ""
    for factor, description in _DRIVES if driven else _RELEASES:
        apart = _apart(first.fit, second.fit, factor)
        if apart > best:
            best, words = apart, description if driven else f"{description} ({factor * amplitude:.3g} {unit})"
    if best < _WORTH:
        return (
            f"No other {'level' if driven else 'release'} would separate {one} from {other} "
            f"on this bench; instead: {first.effect.confirming_test}."
        )
    by = f"{np.sqrt(best):.0f} standard deviations" if best < _BY_FAR else "far more than the noise"
    return f"To separate {one} from {other}, record {words}: there they differ by {by}."


def _amplitude(baseline: Baseline) -> tuple[float, str]:
    prepared = max(baseline.decays, key=lambda s: s.amplitude)
    side = float(np.sign(prepared.motion.displacement[0])) or 1.0
    unit = prepared.window.unit
    scale, name = (1e3, "mm") if unit == "m" and prepared.amplitude < 1.0 else (1.0, unit)
    return scale * side * prepared.amplitude, name


def _comes_back(predicted: dict[str, Array], first: Fit) -> bool:
    """Whether a displacement swings to the other side of rest: a pendulum that is let go above its axis does not."""
    if "displacement" not in predicted:
        return True
    zero = first.values.get(str(nuisance("displacement_offset")))
    swing = predicted["displacement"] - (0.0 if zero is None else zero.value)
    return bool(np.min(swing) < 0.0 < np.max(swing))


def _apart(first: Fit, second: Fit, factor: float) -> float:
    """Return by how much chi-square would favour `first`, were it true, over `second` on one more release."""
    window = first.windows[0]
    moved = first.theta.copy()
    for i, unknown in enumerate(first.unknowns):
        if unknown.window >= 0 and unknown.simulated:  # the state from which the motion starts
            moved[i] *= factor
    if window.force is not None:
        window = window.with_(force=factor * window.force)
    problem = Problem(first.model, (window,), first.frequency)
    predicted = problem.read(moved, 0, problem.respond(moved, 0))
    if not all(np.isfinite(values).all() for values in predicted.values()):
        return 0.0
    if window.force is None and not _comes_back(predicted, first):
        return 0.0
    record: FitWindow = replace(window, readings=predicted)
    beginning = second.point
    for unknown in second.unknowns:
        if unknown.window >= 0:
            value, again = beginning.pop(unknown.name), factor if unknown.simulated else 1.0
            beginning |= {
                str(unknown.id.of_release(i, 2)): value * scale for i, scale in enumerate((1.0, again))
            }
    joint = fit(second.model, (second.windows[0], record), beginning, second.frequency, tolerance=1.0)
    return max(joint.chi_square - second.chi_square, 0.0)
