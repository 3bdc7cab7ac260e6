"""Compare a session with a model, or diagnose several, and keep what was found."""

from pathlib import Path
from typing import Any

from daq.manifest import known_manifest
from daq.session import Session
from identify.comparison.other_benches import other_benches
from identify.diagnosis.diagnose import Diagnosis, diagnose
from identify.fitting.validation import leave_one_out
from identify.formatting import three_figures
from identify.preprocessing.prepared_decay import PreparedDecay
from station.exits import UsageProblem
from station.operations.current_model import current_model
from station.operations.session_set import SessionSet
from station.output import progress as say
from station.own_effects import whole_library
from station.results.diagnosis_document import NAME, DiagnosisDocument, diagnosis_document
from station.results.documents import Errors, keep_document, picked, plain
from station.settings import Settings
from station.story.adequacy import recording_doubt
from station.story.pipeline import Compared, KnownModel, Progress, compare, silent
from station.story.preparation import prepare_session

COMPARISON = "comparison.json"


def compare_session(
    session: Session,
    settings: Settings,
    model_file: Path | None = None,
    effects_file: Path | None = None,
    *,
    prepared: PreparedDecay | None = None,
    tell: Progress = say,
) -> tuple[Compared, dict[str, Any]]:
    """Compare a session with its current model, or that of a file; write results/comparison.json.

    `prepared` is its release, where it was prepared before. `tell` gets a sentence where the session may not be written.
    Returns the comparison and its document.
    """
    if prepared is None:
        prepared = prepare_session(session, settings)
    current = current_model((session,), model_file, whole_library(effects_file))
    compared = compare(session.folder.name, prepared, current)
    document = comparison_document(compared)
    keep_document(session, COMPARISON, document, tell)
    return compared, document


def comparison_document(compared: Compared) -> dict[str, Any]:
    """Make the document of a comparison: how large the errors of a model are, and where.

    `error` is that of the `pieces` in which a long record is judged, `one_run` that of one free run from the release to
    the end; `floor_percent` is what noise alone leaves of the force.
    """
    found = compared.comparison
    fit = compared.baseline.stated(compared.baseline.fit)
    cycles = picked(
        found.cycles, "amplitude", "frequency_error_std", "energy_error", "energy_error_std",
        time_s="time", frequency_error_percent="frequency_error",
    )  # fmt: skip
    return plain(
        {
            "format": 1,
            **picked(compared, "pieces", session="name", model_is="words", model_remark="remark"),
            "model": picked(fit.model, "equation", effects="names") | {"parameters": fit.parameters},
            "error": Errors.model_validate(compared.error),
            "one_run": picked(
                found, force_mse_percent="force_error", motion_percent="motion_error", chi2="chi_square"
            ),
            "noise_floor": dict(found.floor),
            "cycles": cycles | picked(found, "free_run_misfit"),
            **picked(found, "summary", "cause", "places", "unit", floor_percent="force_floor"),
        }
    )


def check_same_bench(sessions: SessionSet, anyway: bool, progress: Progress) -> None:
    """Raise UsageProblem where a stiffness is another by so much that the benches are plainly different, unless `anyway`.

    What was declared as changed on purpose is not looked at.
    """
    if len(sessions.decays) < 2:
        return
    if sessions.varies:
        progress(f"{', '.join(sorted(sessions.varies))}: each session has its own, as declared")
        return
    names = sessions.names
    far = other_benches(sessions.decays)
    if far and not anyway:
        first, *found = (three_figures(sessions.decays[index].frequency ** 2) for index in (0, *far))
        raise UsageProblem(
            f"{', '.join(names[index] for index in far)}: another bench than {names[0]}, since the stiffness per unit mass "
            f"by the force along the motion, {', '.join(found)} against {first} 1/s², differs by more than releases of one "
            "rig do; diagnose them separately, or, if a spring or a mass of one rig was changed, with "
            "--varies stiffness or --varies inertia; --anyway if they share their physics"
        )


def diagnose_sessions(
    sessions: SessionSet,
    model: KnownModel | Path | None = None,
    effects_file: Path | None = None,
    progress: Progress = silent,
    steps: Progress = silent,
    *,
    worth: float = 0.0,
) -> tuple[Diagnosis, DiagnosisDocument]:
    """Diagnose sessions together: what their current model lacks, or another `model`, or that of its file; keep the answer.

    `steps` gets each fit as it is counted, `progress` only the long steps. Returns the diagnosis and its document, which
    of several sessions has the error on each of what was found on the others.
    """
    library = whole_library(effects_file)
    if not isinstance(model, KnownModel):
        model = current_model(sessions.sessions, model, library)
    decays, chosen, left_out = sessions.decays, model.model, None
    progress(f"trying {len(library) - len(chosen.terms)} effects and faults of a sensor")
    known = model.start(decays)
    found = diagnose(decays, chosen, library=library, known=known, worth=worth, progress=steps)
    if len(decays) > 1:
        progress("leaving one session out at a time")
        left_out = leave_one_out(found.final)
    document = diagnosis_document(sessions.names, found, model.expressions, left_out)
    of_sessions = {"varies": sorted(sessions.varies), "left_out": sessions.left_out}
    doubts = ((s.folder.name, recording_doubt(known_manifest(s.folder))) for s in sessions.sessions)
    against = [f"{name}: {doubt}." for name, doubt in doubts if doubt]
    caution = " ".join(filter(None, (document.caution, *against)))
    said = {"model_is": model.words, "model_remark": model.remark, "caution": caution}
    document = document.model_copy(update=of_sessions | said)
    keep(sessions, document, progress)
    return found, document


def keep(sessions: SessionSet, document: DiagnosisDocument, tell: Progress) -> None:
    """Write results/diagnosis.json into each session; `tell` gets a sentence on each that may not be written."""
    for session in sessions.sessions:
        keep_document(session, NAME, document, tell)
