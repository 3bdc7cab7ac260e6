"""Compare a session with a model, and keep what was found in it."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from daq.session import Session
from identify.comparison.compare import Comparison, compare
from identify.effects.library import LIBRARY
from identify.fitting.baseline import Baseline, fit_baseline
from identify.preprocessing.prepared_decay import PreparedDecay, prepare
from station.operations.session_set import chosen_model
from station.output import finite
from station.results.document import estimate
from station.story.compared import Compared
from station.story.pipeline import Options, find_motion, free_decay

RESULT = "comparison.json"
VIEW = "comparison.rrd"


def setting_of(session: Session, options: Options) -> PreparedDecay:
    """Make the release of a session ready to be fitted; raises NotIdentifiable where there is too little of it."""
    decay = free_decay(session.recording(), options)
    release = find_motion(decay)
    return prepare(decay.with_(release=release.index, rest=release.rest), release)


def compare_session(
    session: Session, options: Options, model: Path | None = None
) -> tuple[Compared, dict[str, Any]]:
    """Fit a model to a session, compare, write results/comparison.json; return both forms."""
    return compare_ready(session, setting_of(session, options), options.mass, model)


def compare_ready(
    session: Session, setting: PreparedDecay, mass: float | None, model: Path | None = None
) -> tuple[Compared, dict[str, Any]]:
    """Do the same with a session that was made ready by `setting_of` before."""
    chosen, known, _ = chosen_model(model, (setting,), LIBRARY)
    compared = compare_fitted(session.folder.name, fit_baseline((setting,), chosen, known), mass)
    document = as_document(compared)
    session.write_result(RESULT, json.dumps(finite(document), indent=2, ensure_ascii=False) + "\n")
    return compared, document


def compare_fitted(name: str, start: Baseline, mass: float | None) -> Compared:
    """Compare a model that was fitted already, on the setting as the fit has mended it."""
    setting = start.decays[0]
    found = compare(setting, start.fit, start.floors[0].channels, mass=mass)
    return Compared(name, setting, start, found)


def write_view(session: Session, compared: Compared) -> Path:
    """Write the Compare tab of the viewer into the session's results; return the file."""
    from station.views import compare as tab

    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        tab.write_file(file, compared)
        return session.write_result(VIEW, file.read_bytes())


def as_document(compared: Compared) -> dict[str, Any]:
    """Return a comparison under the keys that other programs rely on."""
    found, fit = compared.comparison, compared.start.fit
    return {
        "session": compared.name,
        "model": {
            "effects": list(fit.model.names),
            "equation": fit.model.equation,
            "parameters": {name: estimate(value) for name, value in fit.parameters.items()},
            "nuisances": {name: estimate(value) for name, value in fit.nuisances.items()},
        },
        "error": {
            "force_mse_percent": found.force_error,
            "force_mse_percent_of_noise": found.force_floor,
            "motion_percent": found.motion_error,
            "motion_channel": found.motion_channel,
            "chi2": found.chi_square,
            "chi2_std": found.chi_square_std,
        },
        "horizon": {"seconds": found.horizon, "cycles": found.horizon_cycles},
        "noise_floor": {
            name: {"std": noise.std, "uncertainty": noise.uncertainty, "source": noise.source}
            for name, noise in found.floor.items()
        },
        "summary": found.summary,
        "cause": found.cause,
        "places": [
            {
                "kind": place.kind,
                "text": place.text,
                "size": place.size,
                "std": place.std,
                "largest": place.largest,
                "unit": place.unit,
                "significance": place.significance,
            }
            for place in found.places
        ],
        "kinematics": _kinematics(found),
        "cycles": {
            "time_s": found.cycles.time.tolist(),
            f"amplitude_{found.unit}": found.cycles.amplitude.tolist(),
            "frequency_error_percent": found.cycles.frequency_error.tolist(),
            "frequency_error_std": found.cycles.frequency_error_std.tolist(),
            "energy_error_per_mass": found.cycles.energy_error.tolist(),
            "energy_error_std": found.cycles.energy_error_std.tolist(),
            "free_run_misfit": found.free_run_misfit.tolist(),
        },
        "phase_plane": {
            "displacement_edges": found.phase_plane.displacement_edges.tolist(),
            "velocity_edges": found.phase_plane.velocity_edges.tolist(),
            "force_per_mass": found.phase_plane.force.tolist(),
            "std": found.phase_plane.std.tolist(),
            "counts": found.phase_plane.counts.tolist(),
        },
        "harmonics": {
            "order": found.harmonics.order.tolist(),
            "with_displacement": found.harmonics.with_displacement.tolist(),
            "with_velocity": found.harmonics.with_velocity.tolist(),
            "significance": found.harmonics.significance.tolist(),
        },
    }


def _kinematics(found: Comparison) -> dict[str, Any] | None:
    checked = found.kinematics
    if checked is None:
        return None
    return {
        "chi2": checked.chi_square,
        "chi2_std": checked.chi_square_std,
        "rms": checked.rms,
        "rms_of_noise": checked.noise,
        "unit": f"{found.unit}/s^2",
    }
