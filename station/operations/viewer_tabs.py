"""Show a model's story: the tabs Suspects and Ladder, in a viewer that is open and in the session's recording."""

import json
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from daq.session import Session
from identify.diagnosis.diagnose import Diagnosis
from identify.effects.effect import Effect
from identify.fitting.baseline import fit_baseline
from identify.fitting.fit import fit
from station.exits import UsageProblem
from station.operations.comparing import RESULT as COMPARISON
from station.operations.diagnosing import RESULT
from station.operations.identifying import options_for
from station.operations.refining import Refinement, open_refinement, rung_again
from station.operations.session_set import begin_from
from station.output import progress
from station.results.ladder import LADDER
from station.results.models import LARGEST, KnownModel, ModelFile, known_model
from station.settings import Settings

if TYPE_CHECKING:
    from station.views.suspects import Shown
    from station.views.tab import Tab

VIEW = "model.rrd"
BEST = 3


def suspects_tab(found: Diagnosis, document: dict[str, Any]) -> "Tab":
    """Return the Suspects tab of a diagnosis."""
    from station.views import suspects
    from station.views.tab import Tab

    told = suspects.shown(found, document)
    return Tab(suspects.NAME, lambda stream: suspects.write(stream, told), lambda: suspects.tab(told))


def suspects_again(refinement: Refinement) -> "Tab | None":
    """Return the Suspects tab of the diagnosis that a session keeps; None when it keeps none that can be read."""
    from station.views import suspects
    from station.views.tab import Tab

    told = told_again(refinement)
    if told is None:
        return None
    return Tab(suspects.NAME, lambda stream: suspects.write(stream, told), lambda: suspects.tab(told))


def told_again(refinement: Refinement) -> "Shown | None":
    """Return the diagnosis that a session keeps with its fits found again; None when it keeps none that can be read."""
    from station.views import suspects

    file = refinement.session.results / RESULT
    setting, library = refinement.setting, refinement.library
    if not file.is_file():
        return None
    try:
        document, (known, *others) = kept_diagnosis(file, library)
    except UsageProblem as error:
        progress(f"{error} to see the suspects")
        return None
    base = fit_baseline((setting,), known.model, begin_from(known, (setting,))).fit
    best = []
    for its in others:
        start = begin_from(its, (setting,))
        best.append((its.model.terms[-1], fit(its.model, base.windows, start, base.frequency)))
    return suspects.Shown(document, setting, 0, base, tuple(best))


def kept_diagnosis(file: Path, library: tuple[Effect, ...]) -> tuple[dict[str, Any], list[KnownModel]]:
    """Return a kept diagnosis with its model and those of the best suspects; UsageProblem when it cannot be read."""
    try:
        if file.stat().st_size > LARGEST:
            raise ValueError("it is larger than any diagnosis is")
        document = json.loads(file.read_text(encoding="utf-8"))
        models = [ModelFile.model_validate_json(json.dumps(part)) for part in _models(document)]
        return document, [known_model(model, str(file), library) for model in models]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OSError, UsageProblem) as error:
        # written by another version, or altered
        raise UsageProblem(f"{file} cannot be read; diagnose again") from error


def _models(document: dict[str, Any]) -> list[Any]:
    """Return the model that was diagnosed and those of the best suspects."""
    best = [suspect["model"] for suspect in document["suspects"][:BEST]]
    return [document["fitted"], *(model for model in best if model is not None)]


def ladder_tab(refinement: Refinement, root: str = "/ladder") -> "Tab":
    """Return the Ladder tab of a session; each rung's fit is found again from its values."""
    from station.views import ladder
    from station.views.tab import Tab

    kept = refinement.ladder
    fits = tuple(rung_again(refinement, rung).fit for rung in kept.rungs[: kept.present + 1])
    climbed = ladder.Climbed(refinement.session.folder.name, kept, refinement.setting, fits)
    return Tab(
        ladder.NAME, lambda stream: ladder.write(stream, climbed, root), lambda: ladder.tab(climbed, root)
    )


def kept_tabs(refinement: Refinement) -> tuple["Tab", ...]:
    """Return the tabs of what a session's results hold: Suspects after a diagnosis, Ladder after a refinement."""
    suspects = suspects_again(refinement)
    has_ladder = (refinement.session.results / LADDER).is_file()
    return (*([suspects] if suspects else []), *([ladder_tab(refinement)] if has_ladder else []))


def story_tabs(session: Session, settings: Settings) -> tuple["Tab", ...]:
    """Return the tabs Compare, Suspects and Ladder, as far as a session's results hold what they show."""
    results = session.results
    tabs: list[Tab] = []
    if (results / COMPARISON).is_file():
        tabs.append(_compare_tab(session, settings))
    if (results / RESULT).is_file() or (results / LADDER).is_file():
        try:
            tabs += kept_tabs(open_refinement(session, settings))
        except UsageProblem as problem:  # an effect of the user's own file, which is not at hand here
            progress(f"the tabs Suspects and Ladder are left out: {problem}")
    return tuple(tabs)


def _compare_tab(session: Session, settings: Settings) -> "Tab":
    from station.operations.comparing import compare_session
    from station.views import compare
    from station.views.tab import Tab

    compared, _ = compare_session(session, options_for(session, settings))
    return Tab(compare.NAME, lambda stream: compare.write(stream, compared), lambda: compare.tab(compared))


def show_suspects(session: Session, found: Diagnosis, document: dict[str, Any]) -> bool:
    """Show a diagnosis in the viewer that is open, or in a new one; False where there is neither."""
    from station.views.open_viewer import url_or_new

    url = url_or_new()
    if url is None:
        return False
    from station.views import modelling
    from station.views.log import TIMELINE

    modelling.send(url, _recording(session), (suspects_tab(found, document),), TIMELINE)
    return True


def show_ladder(refinement: Refinement, at: str | None = None) -> bool:
    """Show the ladder in the viewer `at` a URL, else in the one that is open, or in a new one; False where there is none.

    Every call draws under a path of its own, since what was logged at a rung before cannot be replaced.
    """
    from station.views.open_viewer import url_or_new

    url = at or url_or_new()
    if url is None:
        return False
    from station.views import ladder, modelling

    suspects = suspects_again(refinement)
    tabs = (ladder_tab(refinement, f"/ladder/{time.time_ns()}"), *([suspects] if suspects else []))
    modelling.send(url, _recording(refinement.session), tabs, ladder.TIMELINE)
    return True


def _recording(session: Session) -> str:
    return f"{session.folder.name}-model"


def keep_view(session: Session, tabs: tuple["Tab", ...], timeline: str) -> Path:
    """Write the tabs into the session's results as a recording; return the file."""
    from station.views import modelling

    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        modelling.write_file(file, _recording(session), tabs, timeline)
        return session.write_result(VIEW, file.read_bytes())
