"""Refine: add or remove one effect of a session's model, or add all that is missing; the ladder is kept."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from daq.session import Session
from identify.diagnosis.diagnose import diagnose
from identify.diagnosis.ladder import (
    Step,
    add_effect,
    first_step,
    needless_share,
    remove_effect,
    without_needless_effects,
)
from identify.effects.effect import Effect
from identify.fitting.model_error import noise_percent
from identify.formatting import plain_name, three_figures
from identify.judging.nonparametric_force import curve_of_rest
from identify.preprocessing.prepared_decay import PreparedDecay
from identify.residual import residual_words
from station.exits import UsageProblem
from station.operations.current_model import first_model
from station.own_effects import named_effect, whole_library
from station.results.documents import seen, to_text
from station.results.ladder import LADDER, KeptLadder, KeptStep, read_ladder, write_ladder
from station.results.models import known_model, model_file, name_of, parsed_effect
from station.settings import Settings
from station.story.engineering_values import Weighing
from station.story.preparation import prepare_session, weighing_of
from station.suggestions import MEASURED_CURVE, did_you_mean


@dataclass(frozen=True, eq=False)
class Refinement:
    """A session's ladder with what it takes to go on: its release, the library, and what puts the mass into strengths.

    `fitted` are steps that were fitted while this lives, by the text of their model.
    """

    session: Session
    prepared: PreparedDecay
    library: tuple[Effect, ...]
    ladder: KeptLadder
    weighing: Weighing
    fitted: dict[str, Step] = field(default_factory=dict)


def open_refinement(
    session: Session,
    settings: Settings,
    model_file: Path | None = None,
    effects_file: Path | None = None,
    *,
    reset: bool = False,
) -> Refinement:
    """Open the ladder of a session; begin one where there is none, where a model is given, or on `reset`.

    A ladder that begins is not kept before its first step, or before `write_ladder`.
    Raises NotIdentifiable when the session holds too little.
    """
    library = whole_library(effects_file)
    replaced = seen(session, LADDER) if reset or model_file is not None else None
    ladder = None if reset or model_file is not None else read_ladder(session)
    prepared = prepare_session(session, settings)
    if ladder is None:
        begun = first_model((session,), model_file, library)
        step = first_step((prepared,), begun.model, begun.start((prepared,)))
        ladder = KeptLadder(
            format=1,
            steps=(_kept(step, begun.expressions, begun.words),),
            present=0,
            seen=replaced,
        )
    weighing = weighing_of(session, settings, prepared.window.unit)
    return Refinement(session, prepared, library, ladder, weighing)


def step_again(refinement: Refinement, step: KeptStep) -> Step:
    """Fit a kept step again from its values, unless this was done before."""
    found = refinement.fitted.get(to_text(step.model))
    if found is None:
        known = known_model(step.model, "the ladder", refinement.library)
        found = first_step((refinement.prepared,), known.model, known.values | step.nuisances)
        refinement.fitted[to_text(step.model)] = found
    return found


def add(refinement: Refinement, wanted: str) -> KeptLadder:
    """Add an effect of the library, of the user's file, or an expression as "magnet = a*u/(1+(u/b)**2)".

    `measured_curve` adds what the model leaves as a spline over the coordinate that it depends on.
    """
    step, why = tried(refinement, wanted)
    return _extended(refinement, (step,), why)


def tried(refinement: Refinement, wanted: str) -> tuple[KeptStep, str]:
    """Fit what `add` would keep; return the step, and what to say of it. Nothing is kept."""
    expressions = refinement.ladder.top.model.expressions
    top = step_again(refinement, refinement.ladder.top)
    effect: Effect
    if wanted == MEASURED_CURVE:
        names = (MEASURED_CURVE, *(f"{MEASURED_CURVE}_{n}" for n in range(2, 99)))
        effect, line = curve_of_rest(top.baseline, next(name for name in names if name not in top.effects))
        expressions = (*expressions, line)
    elif "=" in wanted:
        try:
            effect = parsed_effect(wanted)
        except ValueError as error:
            raise UsageProblem(str(error)) from error
        if any(effect.name == other.name for other in refinement.library):
            raise UsageProblem(f"{effect.name} is in the library already; choose another name for your own")
        expressions = (*(text for text in expressions if name_of(text) != effect.name), wanted)
    else:
        effect = named_effect(wanted, refinement.library)
    try:
        step = add_effect(top, effect)
    except ValueError as error:
        raise UsageProblem(f"{wanted}: {error}") from error
    kept = _kept(step, expressions)
    refinement.fitted[to_text(kept.model)] = step
    return kept, _added(step, effect.name, top)


def remove(refinement: Refinement, name: str) -> KeptLadder:
    """Take an effect out of the present model."""
    top = step_again(refinement, refinement.ladder.top)
    if name not in top.effects:
        raise UsageProblem(
            f"{name} is not in the model ({', '.join(top.effects)}){did_you_mean(name, top.effects)}"
        )
    if len(top.effects) == 1:
        raise UsageProblem(f"{name} is all that the model has; add something before removing it")
    step = remove_effect(top, name)
    kept = _kept(step, refinement.ladder.top.model.expressions)
    return _extended(refinement, (kept,), _manual(step, f"{plain_name(name)} was removed"))


def refine_to_floor(refinement: Refinement, found_so_far: Callable[[KeptLadder, str], None]) -> KeptLadder:
    """Add what is missing until nothing is; each step is kept as soon as it is found.

    `found_so_far` gets the kept ladder after each step, and the step in words.
    """
    kept, top = refinement.ladder, refinement.ladder.top
    known = known_model(top.model, "the ladder", refinement.library)

    def on_step(step: Step, words: str) -> None:
        nonlocal kept
        if step.added or step.removed:
            new = _kept(step, top.model.expressions)
            kept = _extended(replace(refinement, ladder=kept), (new,), f"as found so far, {words}")
        left = residual_words(step.error.motion_percent, step.error.chi_square)
        found_so_far(kept, f"{words}: {left} ({' + '.join(plain_name(name) for name in step.effects)})")

    start = known.values | top.nuisances
    first = diagnose(refinement.prepared, known.model, library=refinement.library, known=start)
    found = first.refine(on_step)
    ended = kept.with_(stopped_because=found.stopped_because, verdict=found.verdict)
    return write_ladder(refinement.session, ended)


def drop_needless(refinement: Refinement) -> tuple[KeptLadder, str]:
    """Take out the effects without which the residual hardly rises, the least useful first; what was begun with stays.

    Returns the ladder, which is kept, and a sentence.
    """
    ladder = refinement.ladder
    dropped = without_needless_effects(step_again(refinement, ladder.top), set(ladder.steps[0].effects))
    if not dropped:
        return ladder, "Each effect that was added is needed: without it the residual rises."
    steps = tuple(_kept(step, ladder.top.model.expressions) for step in dropped)
    names = ", ".join(plain_name(step.removed) for step in dropped)
    words = f"removed, because without it the residual hardly rises: {names}"
    return _extended(refinement, steps, words), f"{words[:1].upper()}{words[1:]}."


def go_to(refinement: Refinement, number: int) -> KeptLadder:
    """Make step `number` (0 is the first) the present model; the steps above it stay until something is added."""
    ladder = refinement.ladder
    if not 0 <= number < len(ladder.steps):
        raise UsageProblem(f"--to {number}: the ladder has steps 0 to {len(ladder.steps) - 1}")
    if number != ladder.present:
        why = f"gone back to step {number}" if number < len(ladder.steps) - 1 else ""
        ladder = ladder.with_(present=number, stopped_because=why, verdict=None)
    return write_ladder(refinement.session, ladder)


def _kept(step: Step, expressions: tuple[str, ...], begun_with: str = "") -> KeptStep:
    """Make the document of a step; `begun_with` says of the first which model it is."""
    return KeptStep.of(
        step,
        model=model_file(step.stated, expressions),
        floor_percent=noise_percent(step.fit),
        nuisances={name: found.value for name, found in step.fit.nuisances.items()},
        begun_with=begun_with,
    )


def _extended(refinement: Refinement, new: tuple[KeptStep, ...], why: str) -> KeptLadder:
    ladder = refinement.ladder
    steps = (*ladder.steps[: ladder.present + 1], *new)
    changed = ladder.with_(steps=steps, present=len(steps) - 1, stopped_because=why, verdict=None)
    return write_ladder(refinement.session, changed)


def _added(step: Step, name: str, before: Step) -> str:
    """Say how much of the residual an added effect explains."""
    share = needless_share(step, before)
    if share is None:
        return _manual(step, f"{plain_name(name)} was added")
    percent = "less than 0.01" if share < 1e-4 else three_figures(100.0 * share)
    return (
        f"{plain_name(name)} explains nothing ({percent} % of the residual, no more than chance would): remove it "
        f"with --remove {name}"
    )


def _manual(step: Step, done: str) -> str:
    if step.at_floor:
        return f"{done}; the noise floor is reached"
    left = residual_words(step.error.motion_percent, step.error.chi_square, step.error.floor_std)
    return f"{done}; the model leaves {left}"
