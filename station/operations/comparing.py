"""Compare a session with a model, and keep what was found in it."""

from pathlib import Path
from typing import Any

from daq.session import Session
from identify.preprocessing.prepared_decay import PreparedDecay
from station.operations.current_model import current_model
from station.operations.record_floor import with_floor
from station.output import progress
from station.own_effects import whole_library
from station.results.documents import Errors, keep_document, picked, plain
from station.settings import Settings
from station.story.pipeline import Compared, Progress, compare
from station.story.preparation import prepare_session

NAME = "comparison.json"


def compare_session(
    session: Session,
    settings: Settings,
    model_file: Path | None = None,
    effects_file: Path | None = None,
    *,
    prepared: PreparedDecay | None = None,
    tell: Progress = progress,
) -> tuple[Compared, dict[str, Any]]:
    """Compare a session with its current model, or that of a file; write results/comparison.json.

    `prepared` is its release, where it was prepared before. `tell` gets a sentence where the session may not be written.
    Returns the comparison and its document.
    """
    if prepared is None:
        prepared = with_floor(session, prepare_session(session, settings))
    current = current_model((session,), model_file, whole_library(effects_file))
    compared = compare(session.folder.name, prepared, current)
    document = comparison_document(compared)
    keep_document(session, NAME, document, tell)
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
