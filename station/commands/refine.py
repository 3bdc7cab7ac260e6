"""`station refine`: add an effect and watch the error fall."""

from pathlib import Path

import click

from station.commands.options import (
    EFFECTS,
    MODEL,
    NO_VIEWER,
    SESSION,
    declared,
    option,
)
from station.exits import UsageProblem
from station.output import progress
from station.settings import Settings


@declared("refine")
def command(
    settings: Settings,
    session: str = SESSION,
    added: tuple[str, ...] = option(
        'A name, or "magnet = a*u/(1+(u/b)**2)", or measured_curve.',
        "--add",
        multiple=True,
        metavar="EFFECT",
    ),
    removed: str | None = option("Remove an effect from the model.", "--remove", metavar="EFFECT"),
    auto: bool = option("Add what is missing until the noise floor is reached; say why it stops."),
    number: int | None = option("Go back to step N.", "--to", type=click.IntRange(min=0), metavar="N"),
    reset: bool = option("Begin the ladder again."),
    model_file: Path | None = MODEL,
    effects_file: Path | None = EFFECTS,
    no_viewer: bool = NO_VIEWER,
) -> None:
    """Add an effect to the model of SESSION and watch the error fall.

    The model, and every step of the ladder that led to it, are kept in the
    session. Without an option the ladder is printed. "% of motion" is of the
    displacement (without one, of the first channel), "times noise" of all,
    with the readings that a fault has spoilt until the model names it.
    """
    steps = {"--add": added, "--remove": removed, "--auto": auto, "--to": number is not None}
    if len(wanted := [option for option, given in steps.items() if given]) > 1:
        raise UsageProblem(f"{' and '.join(wanted)} do not go together; one step at a time")
    from dataclasses import replace

    from station.operations.refining import add, go_to, open_refinement, refine_to_floor, remove
    from station.operations.viewer_tabs import show_refined
    from station.own_effects import named_effect, whole_library
    from station.results.documents import seen
    from station.results.ladder import LADDER, ladder_document, write_ladder
    from station.results.sessions import open_session
    from station.suggestions import MEASURED_CURVE
    from station.text.ladder_text import next_command, told
    from station.text.layout import answer

    library = whole_library(effects_file)
    for name in added:  # before the first of them is fitted
        if "=" not in name and name != MEASURED_CURVE:
            named_effect(name, library)
    opened = open_session(session, settings.sessions)
    changes = bool(wanted) or reset or model_file is not None or seen(opened, LADDER) is None
    if changes:
        opened.require_writable()
    refinement = open_refinement(opened, settings, model_file, effects_file, reset=reset)
    ladder = refinement.ladder
    for name in added:
        ladder = add(replace(refinement, ladder=ladder), name)
    if removed:
        ladder = remove(refinement, removed)
    elif auto:
        ladder = refine_to_floor(refinement, lambda _, words: progress(words))
    elif number is not None:
        ladder = go_to(refinement, number)
    elif not added and (reset or model_file is not None or ladder.seen is None):
        ladder = write_ladder(opened, ladder)
    words, document = told(ladder, refinement.weighing), ladder_document(opened, ladder)
    answer(document, words, *next_command(ladder, opened.folder), full=True)
    if changes and not no_viewer:
        show_refined(replace(refinement, ladder=ladder), settings)
