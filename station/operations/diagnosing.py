"""Diagnose one or several sessions and keep what was found."""

from pathlib import Path

from identify.comparison.shared_physics import OTHER_BENCH, SharedPhysics, shared_physics
from identify.diagnosis.diagnose import Diagnosis
from station.exits import UsageProblem
from station.operations.current_model import CurrentModel, current_model
from station.operations.session_set import SessionSet
from station.own_effects import whole_library
from station.results.diagnosis_document import NAME, DiagnosisDocument, diagnosis_document
from station.results.documents import write_document
from station.story.pipeline import Progress, diagnose, silent
from station.text.next_step import command_line


def physics_shared(sessions: SessionSet, anyway: bool, progress: Progress) -> SharedPhysics | None:
    """Say whether sessions share their physics, each looked at alone; None with a single one.

    Raises UsageProblem where a stiffness is another by so much that the benches are plainly different, unless `anyway`.
    """
    if len(sessions.decays) < 2:
        return None
    if sessions.varies:
        progress(f"{', '.join(sorted(sessions.varies))}: each session has its own, as declared")
        return None
    shared, names = shared_physics(sessions.decays), sessions.names
    for difference in shared.differences:
        progress(f"{names[difference.index]}: {difference.words(names[0])}")
    if shared.differences:
        progress(
            "the sessions differ: each gets a spring and viscous damping of its own; any other difference counts against "
            f"the common model. To look at one alone: {command_line('diagnose', names[0])}"
        )
    else:
        progress(f"the {len(names)} sessions share stiffness and friction, as far as each alone can say")
    others = [names[index] for index in shared.other_benches]
    if others and not anyway:
        raise UsageProblem(
            f"{', '.join(others)}: another bench than {names[0]}, since the stiffness per unit mass differs by more than a "
            f"factor of {OTHER_BENCH:g}; diagnose them separately, or, if a spring or a mass of one rig was changed, with "
            "--varies stiffness or --varies inertia; --anyway if they share their physics"
        )
    return shared


def diagnose_sessions(
    sessions: SessionSet,
    model: CurrentModel | Path | None = None,
    effects_file: Path | None = None,
    progress: Progress = silent,
    steps: Progress = silent,
    *,
    worth: float = 0.0,
) -> tuple[Diagnosis, DiagnosisDocument]:
    """Diagnose sessions together: what their current model lacks, or another `model`, or that of its file.

    Returns the diagnosis and its document, which `keep` writes; see `pipeline.diagnose`.
    """
    library = whole_library(effects_file)
    if not isinstance(model, CurrentModel):
        model = current_model(sessions.sessions, model, library)
    found, left_out = diagnose(
        sessions.decays,
        model.model,
        model.start(sessions.decays),
        library=library,
        worth=worth,
        progress=progress,
        steps=steps,
    )
    document = diagnosis_document(sessions.names, found, model.expressions, left_out)
    known = {"varies": sorted(sessions.varies), "left_out": sessions.left_out}
    known |= {"model_is": model.words, "model_remark": model.remark}
    return found, document.model_copy(update=known)


def keep(sessions: SessionSet, document: DiagnosisDocument) -> None:
    """Write results/diagnosis.json into each session."""
    for session in sessions.sessions:
        write_document(session, NAME, document)
