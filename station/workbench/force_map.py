"""Fingerprints for the page: the force that the model lacks, and what each suspect would add, as plain numbers."""

from typing import Any

import numpy as np

from identify.diagnosis.diagnose import Diagnosis
from identify.diagnosis.force_map import ForceMap, force_added, force_left, force_map
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import Fit, fit
from identify.model.model import Term
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.refining import Refinement
from station.operations.session_set import begin_from
from station.results.models import ModelFile, known_model
from station.text.diagnosis_text import shown_suspects
from station.workbench import view_models
from station.workbench.build_view_models import for_eye

RESIDUAL = ""
"""The key of the force that the model lacks, among fingerprints by effect's name."""

MOST = 8


def prints_of(setting: PreparedDecay, found: Diagnosis) -> dict[str, view_models.Print]:
    """Return the fingerprints of a diagnosis of one session that was just made."""
    setting, base = found.start.decays[0], found.start.fit
    best = [(s.term, s.fit) for s in found.suspects[:MOST]]
    return _prints(setting, base, best)


def prints_of_kept(refinement: Refinement, document: dict[str, Any]) -> dict[str, view_models.Print]:
    """Return the same from a diagnosis that was kept: its fits are found again from their values."""
    setting, library = refinement.setting, refinement.library
    try:
        kept = ModelFile.model_validate_json(_json(document["fitted"]))
        known = known_model(kept, "the diagnosis", library)
        base = fit_baseline((setting,), known.model, begin_from(known, (setting,))).fit
        best = []
        for suspect in shown_suspects(document)[:MOST]:
            if suspect["model"] is None:
                continue
            its = known_model(ModelFile.model_validate_json(_json(suspect["model"])), "a suspect", library)
            start = begin_from(its, (setting,))
            best.append((its.model.terms[-1], fit(its.model, base.windows, start, base.frequency)))
    except (ValueError, KeyError, TypeError, UsageProblem):  # written by another version, or altered
        return {}
    return _prints(setting, base, best)


def _json(part: Any) -> str:
    import json

    return json.dumps(part)


def _prints(setting: PreparedDecay, base: Fit, best: list[tuple[Term, Fit]]) -> dict[str, view_models.Print]:
    found = {RESIDUAL: _plain(force_map(setting, force_left(setting, base)))}
    for term, its in best:
        if term.effect.name in its.model:
            added = force_added(setting, base, its, term)
            if np.isfinite(added).any():
                found[term.effect.name] = _plain(force_map(setting, added))
    return found


def _plain(found: ForceMap) -> view_models.Print:
    amplitude = found.amplitude / found.amplitude[-1]
    return view_models.Print(for_eye(amplitude), for_eye(found.phase), [for_eye(row) for row in found.force])
