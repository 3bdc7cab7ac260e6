"""The analysis of one session of a campaign, and a key of all that its result depends on."""

import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from daq.errors import StationError
from daq.session import Session
from daq.session_info import State
from daq.session_reading import RAW
from daq.storage import digest, read_regular
from identify.errors import NotIdentifiable
from identify.fitting.baseline import Baseline, fit_baseline
from identify.fitting.model_error import errors_of
from identify.fitting.segments import segments_of
from identify.model.model import base_model
from identify.preprocessing.prepared_decay import PreparedDecay
from station.results.campaign_document import SessionResult
from station.results.documents import picked
from station.settings import Settings, version_of
from station.story.pipeline import Identification, identify
from station.story.preparation import Options, locate, options_for, prepare_recording

LARGEST = 1 << 30
DISTRIBUTION = "free-decay-station"


@dataclass(frozen=True)
class Work:
    """One session for a worker: its folder, the key of its result, and how it is analysed."""

    folder: Path
    key: str
    options: Options
    diagnose: bool = False


def work_on(folder: Path, settings: Settings, diagnose: bool) -> Work:
    """Make the work on a session; StationError when its files cannot be read, or are still written.

    The key is a checksum of all that the result depends on: readings, calibrations, options, the
    program. What else the metadata say is read afresh for every table.
    """
    session = Session.open(folder)
    if session.info.state is State.RECORDING:
        raise StationError("it is being recorded, or was cut off: wait, or seal it by `station recover`")
    options = options_for(session, settings)
    dependent = {
        "readings": digest(read_regular(folder / RAW, LARGEST)),
        "sensors": [sensor.model_dump(mode="json") for sensor in session.info.sensors],
        "rate_std_hz": session.info.rate_std_hz,
        "options": asdict(options),
        "diagnose": diagnose,
        "program": version_of(DISTRIBUTION, ""),
    }
    key = digest(json.dumps(dependent, sort_keys=True).encode())
    return Work(folder, key, options, diagnose)


def perform(work: Work) -> SessionResult:
    """Identify one session, fit the usual model to it and, where it is asked for, diagnose it.

    Raises nothing that is the session's fault, such as too few cycles: the result says why it failed.
    """
    began = time.perf_counter()
    try:
        content = _contents(work)
    except (NotIdentifiable, StationError) as refusal:
        content = {"reason": " ".join(str(refusal).split())}
    seconds = time.perf_counter() - began
    return SessionResult(format=1, session=work.folder.name, key=work.key, seconds=seconds, **content)


def _contents(work: Work) -> dict[str, Any]:
    recording = Session.open(work.folder).recording()
    found = locate(recording, work.options)
    result = identify(recording, work.options, found)
    content: dict[str, Any] = {
        "unit": result.decay.unit,
        "amplitude": None if result.amplitude is None else abs(result.amplitude),
        "parameters": identified_parameters(result),
        "refusals": dict(result.refusals),
    }
    try:
        prepared = prepare_recording(recording, work.options, found)
        if work.diagnose:
            fitted = _diagnosed(prepared)
        else:
            fitted = fit_content(fit_baseline(segments_of(prepared), base_model()))
        content |= fitted | {"parameters": content["parameters"] | fitted["parameters"]}
        if content["amplitude"] is None:
            content["amplitude"] = prepared.amplitude
    except NotIdentifiable as refusal:
        content["refusals"] = content["refusals"] | {"fit": str(refusal)}
    if not content["parameters"]:
        content["reason"] = "; ".join(dict.fromkeys(content["refusals"].values())) or "nothing was identified"
    return content


def identified_parameters(result: Identification) -> dict[str, Any]:
    """Collect the findings of both methods and of the alignment, by "method.parameter"."""
    found: dict[str, Any] = {}
    for method, values in (("wavelet", result.wavelet), ("restoring_force", result.restoring_force)):
        if values is not None:
            found[f"{method}.K"] = values.stiffness
            found |= {f"{method}.mu_{order}": estimate for order, estimate in enumerate(values.damping)}
    if result.alignment is not None:
        found |= {"alignment.lag": result.alignment.lag, "alignment.gain": result.alignment.gain}
    return found


def fit_content(baseline: Baseline) -> dict[str, Any]:
    """Return the parameters of a fitted model, and how far it is from the measurement."""
    parameters = dict(baseline.stated(baseline.fit).parameters)
    errors = picked(errors_of(baseline), "motion_percent", chi2="chi_square", chi2_std="floor_std")
    return {"parameters": parameters, "at_floor": baseline.at_floor, **errors}


def _diagnosed(prepared: PreparedDecay) -> dict[str, Any]:
    from identify.diagnosis.diagnose import diagnose

    found = diagnose(prepared)
    content = fit_content(found.baseline)
    if found.named:
        stated = dict(found.baseline.stated(found.final).parameters)
        content["parameters"] = stated | content["parameters"]
        content |= picked(
            found.error_with_named, chi2_named="chi_square", motion_percent_named="motion_percent"
        )
    return content | {"verdict": found.verdict, "named": found.named}
