"""A comparison as a document: what `--json` prints and `results/comparison.json` keeps."""

from typing import Any

from station.results.documents import Errors, picked, plain
from station.story.compared import Compared

NAME = "comparison.json"


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
