"""Maps of force for the page: the force that the model lacks, and what each suspect would add, as plain numbers."""

import numpy as np

from identify.diagnosis.force_map import ForceMap
from station.results.diagnosis_fits import DiagnosisFits
from station.workbench import view_models
from station.workbench.build_view_models import for_eye

MISSING = ""
"""The key of the force that the model lacks, among maps by effect's name."""

MOST = 8


def force_maps_of(fits: DiagnosisFits) -> dict[str, view_models.ForceMap]:
    """Return the maps of a diagnosis, by effect's name."""
    found = {MISSING: _plain(fits.missing_force())}
    for (_, fit), (term, added) in zip(fits.best, fits.added_forces(), strict=True):
        if term.effect.name in fit.model and np.isfinite(added.force).any():
            found[term.effect.name] = _plain(added)
    return found


def _plain(found: ForceMap) -> view_models.ForceMap:
    amplitude = found.amplitude / found.amplitude[-1]
    return view_models.ForceMap(
        for_eye(amplitude), for_eye(found.phase), [for_eye(row) for row in found.force]
    )
