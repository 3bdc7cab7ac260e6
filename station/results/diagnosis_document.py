"""A diagnosis as a plain document: what `--json` prints and `results/diagnosis.json` keeps."""

from dataclasses import replace
from typing import Any

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.nonparametric_force import NonparametricForce
from identify.diagnosis.suspect import Suspect
from identify.effects.effect import Effect
from identify.fitting.baseline import Baseline
from identify.fitting.corrected_faults import CorrectedFault
from identify.fitting.leave_one_out import LeftOut
from identify.fitting.model_error import ModelError, errors_of
from identify.model.model import Model
from station.results.document import estimate
from station.results.models import as_plain, model_file

MOST_POINTS = 40


def diagnosis_document(
    names: tuple[str, ...],
    found: Diagnosis,
    expressions: tuple[str, ...] = (),
    left_out: tuple[LeftOut, ...] | None = None,
) -> dict[str, Any]:
    """Return a diagnosis of some sessions under the keys that other programs rely on.

    `left_out` are the errors of physics fitted to the other sessions, None with one session. Floats may be infinite.
    """
    start = found.start
    return {
        "sessions": list(names),
        "model": as_plain(model_file(start.fit, expressions)),
        "error": error_document(errors_of(start)),
        "noise_floor": noise_floor(start),
        "verdict": found.verdict,
        "named": list(found.named),
        "suspects": [suspect_document(suspect, expressions) for suspect in found.suspects],
        "together": list(found.together),
        "findings": [_finding(fault) for fault in found.findings],
        "error_with_named": error_document(errors_of(replace(start, fit=found.final))),
        "shape": None if found.shape is None else _shape(found.shape),
        "held_out": None if left_out is None else _left_out(names, left_out),
        "explanation": found.explanation,
        "next_experiment": found.next_experiment,
        "fitted": model_file(start.fit, expressions).model_dump(mode="json"),
    }


def refused_document(names: tuple[str, ...], model: Model, reason: str) -> dict[str, Any]:
    """Return the same document for sessions that hold too little to fit anything."""
    return {
        "sessions": list(names),
        "model": {"effects": list(model.names), "equation": model.equation, "parameters": {}},
        "error": {"force_mse_percent": None, "motion_percent": None, "chi2": None},
        "noise_floor": None,
        "verdict": "not_enough_data",
        "named": [],
        "suspects": [],
        "together": [],
        "findings": [],
        "error_with_named": None,
        "shape": None,
        "held_out": None,
        "explanation": reason,
        "next_experiment": "Record at least eight seconds or ten cycles, from the largest amplitude that is safe.",
    }


def error_document(error: ModelError) -> dict[str, Any]:
    """Return the three errors, with the horizon of the free run and the standard error of the floor."""
    return {
        "force_mse_percent": error.force_mse_percent,
        "motion_percent": error.motion_percent,
        "chi2": error.chi_square,
        "chi2_std": error.floor_std,
        "horizon_s": error.horizon_s,
    }


def noise_floor(start: Baseline) -> dict[str, Any]:
    """Return the noise of each channel, of the first session where there are several, and what it leaves open."""
    unit = start.fit.windows[0].unit
    units = {"displacement": unit, "velocity": f"{unit}/s", "acceleration": f"{unit}/s^2"}
    channels = {
        name: {"std": n.std, "uncertainty": n.uncertainty, "unit": units[name], "source": n.source}
        for name, n in start.floors[0].channels.items()
    }
    return {"chi2": 1.0, "chi2_std": start.spread, "channels": channels}


def suspect_document(suspect: Suspect, expressions: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return one suspect; `model` is the whole model with it, so that it can be looked at again."""
    apart = suspect.effect.name not in suspect.fit.model
    return {
        "effect": suspect.effect.name,
        "title": suspect.effect.title,
        "kind": suspect.kind,
        "channel": suspect.term.channel or None,
        "error_after": suspect.error_after,
        "evidence": suspect.evidence,
        "p_value": suspect.p_value,
        "parameters": {name: estimate(value) for name, value in suspect.parameters.items()},
        "confusable_with": list(suspect.confusable_with),
        "held_out_gain": suspect.held_out_gain,
        "plausible": suspect.plausible,
        "model": None if apart else model_file(suspect.fit, expressions).model_dump(mode="json"),
    }


def _finding(fault: CorrectedFault) -> dict[str, Any]:
    effect: Effect = fault.term.effect
    return {
        "effect": effect.name,
        "title": effect.title,
        "channel": fault.term.channel or None,
        "parameters": {name: estimate(value) for name, value in fault.parameters.items()},
        "chi2_drop": fault.drop,
        "what_to_do": effect.confirming_test,
    }


def _shape(shape: NonparametricForce) -> dict[str, Any]:
    return {
        "explained": shape.explained,
        "coordinates": list(shape.coordinates),
        "curves": [
            {
                "coordinate": curve.coordinate,
                "unit": curve.unit,
                "position": curve.position[:MOST_POINTS].tolist(),
                "force_per_mass": curve.force[:MOST_POINTS].tolist(),
                "std": curve.std[:MOST_POINTS].tolist(),
            }
            for curve in shape.shapes[:2]
        ],
    }


def _left_out(names: tuple[str, ...], left_out: tuple[LeftOut, ...]) -> list[dict[str, Any]]:
    return [
        {"session": names[one.index], "chi2": one.chi_square, "motion_percent": one.motion_percent}
        for one in left_out
    ]
