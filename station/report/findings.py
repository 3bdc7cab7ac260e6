"""What a report tells of: all that is known of a session, what is missing made on the way, and why the rest is left out."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from daq.errors import StationError
from daq.manifest import Manifest
from daq.recording import Recording
from daq.session import Session
from identify.diagnosis.ladder import Rung
from identify.errors import NotIdentifiable
from identify.fitting.baseline import fit_baseline
from identify.model.model import base_model
from station.exits import Problem, UsageProblem
from station.operations.comparing import RESULT as COMPARISON
from station.operations.comparing import as_document, compare_fitted, compare_session, setting_of
from station.operations.diagnosing import RESULT as DIAGNOSIS
from station.operations.diagnosing import diagnose_sessions, keep
from station.operations.identifying import identify_session
from station.operations.refining import Refinement, open_refinement, rung_again
from station.operations.session_set import SessionSet, begin_from, make_ready
from station.operations.viewer_tabs import told_again
from station.results.ladder import LADDER, KeptLadder
from station.results.models import known_model
from station.settings import Settings
from station.story.compared import Compared
from station.story.identification import Identification
from station.story.pipeline import Options
from station.views.suspects import Shown

Tell = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Climb:
    """The ladder of a session, the fit of its present rung, and that model compared with the record."""

    ladder: KeptLadder
    top: Rung
    compared: Compared


@dataclass(eq=False)
class Findings:
    """All that is known of a session; what is None was left out, and `left_out` says why under its name."""

    session: Session
    recording: Recording
    options: Options
    manifest: Manifest | None = None
    identification: Identification | None = None
    document: dict[str, Any] = field(default_factory=dict)
    compared: Compared | None = None
    comparison: dict[str, Any] = field(default_factory=dict)
    diagnosis: dict[str, Any] | None = None
    suspects: Shown | None = None
    climb: Climb | None = None
    left_out: dict[str, str] = field(default_factory=dict)


def gather(session: Session, settings: Settings, options: Options, *, diagnose: bool, tell: Tell) -> Findings:
    """Return all that is known of a session; identifies and compares, and diagnoses on request.

    Raises DataLost when the session holds no sample; what else cannot be done is left out and says why.
    """
    found = Findings(session, session.recording(), options)
    _identify(found)
    _compare(found)
    if diagnose:
        _diagnose(found, settings, tell)
    refinement = _refinement(found, settings)
    if refinement is not None:
        _suspects(found, refinement)
        _climb(found, refinement)
    try:
        found.manifest = session.manifest()  # last, as it knows the results that were just written
    except StationError as error:
        found.left_out["checksums"] = str(error)
    return found


def _identify(found: Findings) -> None:
    try:
        found.identification, found.document = identify_session(found.session, found.options)
    except NotIdentifiable as refusal:
        found.left_out["identification"] = str(refusal)


def _compare(found: Findings) -> None:
    """Compare with the usual model; kept in the session only where no comparison is kept yet."""
    try:
        if (found.session.results / COMPARISON).is_file():
            setting = setting_of(found.session, found.options)
            start = fit_baseline((setting,), base_model())
            found.compared = compare_fitted(found.session.folder.name, start, found.options.mass)
            found.comparison = as_document(found.compared)
        else:
            found.compared, found.comparison = compare_session(found.session, found.options)
    except NotIdentifiable as refusal:
        found.left_out["comparison"] = str(refusal)


def _diagnose(found: Findings, settings: Settings, tell: Tell) -> None:
    try:
        sessions = SessionSet((found.session,), (make_ready(found.session, settings),))
        _, document = diagnose_sessions(sessions, tell=tell)
        keep(sessions, document)
    except NotIdentifiable as refusal:
        found.left_out["suspects"] = str(refusal)


def _refinement(found: Findings, settings: Settings) -> Refinement | None:
    """Open what the session keeps of a model's story; None where it keeps nothing that can be read."""
    results, left_out = found.session.results, found.left_out
    kept = [(results / DIAGNOSIS).is_file(), (results / LADDER).is_file()]
    if not kept[0]:
        left_out.setdefault("suspects", "no diagnosis was made of this session; `station diagnose` makes one")
    if not kept[1]:
        left_out["ladder"] = "the model was not refined in this session; `station refine` does that"
    if not any(kept):
        return None
    try:
        return open_refinement(found.session, settings)
    except (NotIdentifiable, UsageProblem) as refusal:
        for name, there in zip(("suspects", "ladder"), kept, strict=True):
            if there:
                left_out[name] = str(refusal)
        return None


def _suspects(found: Findings, refinement: Refinement) -> None:
    file = found.session.results / DIAGNOSIS
    if not file.is_file():
        return
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        found.suspects = told_again(refinement)
        found.diagnosis = document if found.suspects is None else found.suspects.document
    except UsageProblem as problem:  # an effect of a file that is not at hand
        found.diagnosis = document
        found.left_out["fingerprints"] = str(problem)
    except ValueError:
        found.diagnosis = None
    if found.suspects is None and "fingerprints" not in found.left_out:
        found.diagnosis = None
        found.left_out["suspects"] = f"results/{DIAGNOSIS} cannot be read; diagnose again"


def _climb(found: Findings, refinement: Refinement) -> None:
    if not (found.session.results / LADDER).is_file():
        return
    try:
        top = rung_again(refinement, refinement.ladder.top)
    except (Problem, NotIdentifiable) as refusal:
        found.left_out["ladder"] = str(refusal)
        return
    start = top.start
    if len(start.decays) > 1:  # fitted in episodes, which start each for themselves; compared in one run
        known = known_model(refinement.ladder.top.model, "the ladder", refinement.library)
        setting = refinement.setting
        start = fit_baseline((setting,), known.model, begin_from(known, (setting,)))
    compared = compare_fitted(found.session.folder.name, start, found.options.mass)
    found.climb = Climb(refinement.ladder, top, compared)
