"""Identify a session and keep what was found in it."""

import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from daq.session import Session
from station.exits import NOT_IDENTIFIABLE, Problem
from station.output import finite
from station.results.document import as_document
from station.settings import Settings
from station.story.identification import Identification
from station.story.pipeline import Options, identify

RESULT = "identification.json"
VIEW = "identification.rrd"


class NothingIdentified(Problem):
    """Neither method could identify anything; the message says why."""

    exit_code = NOT_IDENTIFIABLE
    reported = True


def options_for(session: Session, settings: Settings, mass: float | None = None) -> Options:
    """Return the mass as the option, the session or the settings give it, and the orders from the settings."""
    info, specimen = session.info, settings.specimen
    weight: float | None
    error: float | None
    if mass is not None:
        weight, error = mass, None
    elif info.mass_kg is not None:
        weight, error = info.mass_kg, info.mass_std_kg
    else:
        weight, error = specimen.mass_kg, specimen.mass_std_kg
    return Options(weight, error, settings.identify.max_order, settings.identify.stiffness_orders)


def identify_session(session: Session, options: Options) -> tuple[Identification, dict[str, Any]]:
    """Run the pipeline on a session and write results/identification.json; return both forms."""
    result = identify(session.recording(), options)
    document = as_document(session.folder.name, result)
    session.write_result(RESULT, json.dumps(finite(document), indent=2, ensure_ascii=False) + "\n")
    return result, document


def refuse_if_nothing(result: Identification) -> None:
    """Raise NothingIdentified when both methods refused."""
    if result.wavelet is None and result.restoring_force is None:
        reasons = dict.fromkeys(result.refusals[step] for step in ("wavelet", "restoring_force"))
        raise NothingIdentified("nothing could be identified: " + "; ".join(reasons))


def write_view(session: Session, result: Identification, more: tuple[Any, ...] = ()) -> Path:
    """Write the tabs of the viewer into the session's results, `more` after those of the identification."""
    from station.views import show

    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        show.write(file, session.folder.name, result, more)
        return session.write_result(VIEW, file.read_bytes())
