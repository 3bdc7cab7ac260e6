"""The tasks of a worker for the ladder: each calls the same functions as the commands, and returns plain values.

A task is given the settings, what to call with words or with a part of what it finds, and the session's folder.
"""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from daq.exporting import encode
from daq.importing.reading import look_at
from identify.comparison.compare import compare_fitted
from identify.diagnosis.ladder import add_effect, first_step
from identify.effects.force_effect import ForceEffect
from identify.effects.library import LIBRARY, NAMED
from identify.errors import NotIdentifiable
from identify.residual import explained_words
from station.exits import Problem, UsageProblem
from station.operations.current_model import current_model
from station.operations.diagnosing import check_same_bench, compare_session, diagnose_sessions
from station.operations.examples import EXAMPLES, examples_folder
from station.operations.exporting import fitted_samples
from station.operations.mystery import hidden_words, what_was_hidden
from station.operations.refining import Refinement, open_refinement, refine_to_floor, tried
from station.operations.session_set import SessionSet, open_sessions
from station.operations.workers import Say
from station.results.diagnosis_document import SuspectDocument
from station.results.ladder import KeptLadder, write_ladder
from station.results.models import name_of, parsed_effect
from station.results.sessions import doubt
from station.settings import Settings
from station.story.preparation import Options, prepare_recording
from station.suggestions import MEASURED_CURVE
from station.text.numbers import typeset
from station.workbench.frames import frame_id
from station.workbench.opened_session import Opened, kept_diagnosis, open_session, session_stamp
from station.workbench.statements import called, with_effect
from station.workbench.view_models import MOST_CARDS, Drawn, View


def look(settings: Settings, say: Say, folder: Path) -> View:
    """View a session as its results stand."""
    say("reading the session")
    opened = open_session(settings, folder)
    return _view(settings, opened, opened.refinement.ladder, doubt(folder))


def _view(settings: Settings, opened: Opened, ladder: KeptLadder, note: str = "") -> View:
    """View a ladder; the frame of the present step comes with it, the others when `complete` is asked."""
    session, weighing = opened.refinement.session, opened.refinement.weighing
    names = tuple(frame_id(step.model) for step in ladder.steps)
    opened.draw_step(ladder.top)
    own = dict.fromkeys(text for step in ladder.steps for text in step.model.expressions)
    effects = {effect.name: effect for effect in (*NAMED, *map(parsed_effect, own))}
    present = weighing.terms(effects[name] for name in ladder.top.effects)
    return View(
        ladder,
        kept_diagnosis(session),
        {name: typeset(effect.equation) for name, effect in effects.items()},
        session_stamp(session.folder),
        opened.stage,
        {name: opened.drawn[name][0] for name in names if name in opened.drawn},
        names,
        note,
        typeset(f"{' + '.join(present)} = 0"),
        weighing,
        session.info.specimen.startswith("mystery "),
    )


def change(settings: Settings, say: Say, folder: Path, does: Callable[..., Any], *wanted: Any) -> View:
    """Change the ladder by a function of `station.operations.refining`, which is given what is `wanted`.

    It returns the ladder, or the ladder with a sentence.
    """
    say("fitting")
    opened = open_session(settings, folder)
    found = does(opened.refinement, *wanted)
    return _view(settings, opened, *(found if isinstance(found, tuple) else (found,)))


def restore(refinement: Refinement, ladder: KeptLadder) -> KeptLadder:
    """Keep a ladder as it was before a change; it follows what is kept now."""
    return write_ladder(refinement.session, ladder)


def refine(settings: Settings, say: Say, folder: Path) -> View:
    """Add what is missing until nothing is; each step is sent as a view as soon as it is found."""
    say("looking for what is missing")
    opened = open_session(settings, folder)

    def seen(ladder: KeptLadder, words: str) -> None:
        say(_view(settings, opened, ladder))
        say(words)

    return _view(settings, opened, refine_to_floor(opened.refinement, seen))


def begin_again(settings: Settings, say: Say, folder: Path) -> View:
    """Begin the ladder again with the base model."""
    say("fitting")
    opened = open_session(settings, folder)
    refinement = open_refinement(opened.refinement.session, settings, reset=True)
    return _view(settings, opened, write_ladder(refinement.session, refinement.ladder))


def reveal(settings: Settings, say: Say, folder: Path) -> View:
    """Say what the board of a mystery hid, and whether the present model has it."""
    opened = open_session(settings, folder)
    ladder, truth = opened.refinement.ladder, what_was_hidden(opened.refinement.session)
    solved = "in your model: solved" if truth["hidden"] in ladder.top.effects else "not in your model yet"
    return _view(settings, opened, ladder, f"The simulated board hid {hidden_words(truth)}. It is {solved}.")


def diagnose(settings: Settings, say: Say, folder: Path, others: tuple[Path, ...]) -> View:
    """Find what the present model lacks on this release, and on others with it; keep the answer."""
    opened = open_session(settings, folder)
    refinement = opened.refinement
    session = refinement.session
    session.require_writable()
    sessions = SessionSet((session,), (refinement.prepared,))
    if others:
        sessions = open_sessions((str(folder), *(str(other) for other in others)), settings)
        check_same_bench(sessions, False, say)
    diagnose_sessions(sessions, current_model((session,)), None, say, say)
    opened = open_session(settings, folder)  # a command may have changed it meanwhile
    return _view(settings, opened, opened.refinement.ladder)


def complete(settings: Settings, say: Say, folder: Path, suspects: list[SuspectDocument]) -> None:
    """Draw all steps and the suspects of the present model, say where it fails, and send each as soon as it is known."""
    opened = open_session(settings, folder)
    refinement = opened.refinement
    frame = opened.drawn[opened.draw_step(refinement.ladder.top)][0]
    if "summary" not in frame:
        with contextlib.suppress(Problem, NotIdentifiable):
            found, _ = compare_session(refinement.session, settings, prepared=refinement.prepared, tell=say)
            frame["summary"] = typeset(found.comparison.summary)
    names = [opened.draw_step(step) for step in refinement.ladder.steps]
    say(Drawn({name: opened.drawn[name][0] for name in names}))
    for drawn in _suspects(opened, suspects):
        say(drawn)


def _suspects(opened: Opened, suspects: list[SuspectDocument]) -> Iterator[Drawn]:
    shown = [suspect for suspect in suspects if suspect.model is not None][:MOST_CARDS]
    for suspect in shown:
        assert suspect.model is not None
        with contextlib.suppress(NotIdentifiable, UsageProblem):  # shown without a picture
            name = opened.draw_suspect(suspect.model)
            yield Drawn({name: opened.drawn[name][0]}, {suspect.effect: name})
    if shown and not opened.refinement.ladder.top.at_floor:
        with contextlib.suppress(Problem, NotIdentifiable):  # it has no card then
            yield _tried(opened, MEASURED_CURVE)


def preview(settings: Settings, say: Say, folder: Path, wanted: str) -> Drawn:
    """Draw the present model with an expression of the user's own; nothing is kept."""
    opened = open_session(settings, folder)
    opened.present_fit()
    return _tried(opened, wanted)


def _tried(opened: Opened, wanted: str) -> Drawn:
    """Draw the present model with `wanted` added, and say what it leaves."""
    key = frame_id(opened.refinement.ladder.top.model), wanted
    if key in opened.previews:
        return opened.previews[key]
    step, _ = tried(opened.refinement, wanted)
    name, error, effect = opened.draw_step(step), step.error, name_of(wanted)
    more = "Fitted to this release; Add keeps it."
    ladder = opened.refinement.ladder
    words = explained_words(ladder.top.error.chi2, error.chi2, ladder.top.error.chi2_std)
    says = with_effect(ladder, called(wanted), error.motion_percent, error.chi2, words, more)
    opened.previews[key] = Drawn({name: opened.drawn[name][0]}, {effect: name}, {effect: says})
    return opened.previews[key]


def export(settings: Settings, say: Say, folder: Path) -> str:
    """Write the aligned channels, the present model and the residuals as CSV."""
    say("writing the samples")
    opened = open_session(settings, folder)
    return encode(fitted_samples(opened.refinement, opened.present_fit()), "csv").decode()


def warm_up(*_: object) -> None:
    """Fit, extend and compare a recording that comes with the station; a worker's task like the others."""
    recording = look_at(examples_folder() / EXAMPLES[0].file).read().recordings[0]
    prepared = prepare_recording(recording, Options())
    friction = next(e for e in LIBRARY if isinstance(e, ForceEffect) and e.friction is not None and e.inner)
    step = add_effect(first_step((prepared,)), friction)
    compare_fitted(step.baseline)
