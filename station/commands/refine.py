"""`station refine`: the next model of a session, and the ladder of errors that led to it."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from station.commands.options import EFFECTS, GAIN, MODEL, NO_VIEWER, SESSION, known_effect, pass_settings
from station.exits import UsageProblem
from station.output import json_option, progress
from station.settings import Settings

if TYPE_CHECKING:
    from daq.session import Session
    from station.results.ladder import KeptLadder


@click.command("refine")
@SESSION
@click.option(
    "--add",
    "added",
    metavar="EFFECT",
    callback=known_effect,
    help='A name, or "magnet = a*u/(1+(u/b)**2)", or measured_curve.',
)
@click.option("--remove", "removed", metavar="EFFECT", help="Take an effect out of the model.")
@click.option(
    "--auto", is_flag=True, help="Add what is missing until the noise floor is reached; say why it stops."
)
@click.option("--to", "number", type=click.IntRange(min=0), metavar="N", help="Go back to step N.")
@click.option("--reset", is_flag=True, help="Begin the ladder again.")
@MODEL
@EFFECTS
@GAIN
@NO_VIEWER
@json_option
@pass_settings
def command(
    settings: Settings,
    session: str,
    added: str | None,
    removed: str | None,
    auto: bool,
    number: int | None,
    reset: bool,
    model_file: Path | None,
    effects_file: Path | None,
    gain_percent: float | None,
    no_viewer: bool,
    as_json: bool,
) -> None:
    """Add an effect to the model of SESSION and watch the error fall.

    The model, and every step of the ladder that led to it, are kept in the
    session. Without an option the ladder is printed.
    """
    steps = {"--add": added, "--remove": removed, "--auto": auto, "--to": number is not None}
    if len(wanted := [option for option, given in steps.items() if given]) > 1:
        raise UsageProblem(f"{' and '.join(wanted)} do not go together; one step at a time")
    from dataclasses import replace

    from station.operations.refining import add, go_to, open_refinement, refine_to_floor, remove
    from station.results.ladder import ladder_document, write_ladder
    from station.results.sessions import open_session
    from station.story.preparation import weighing_of
    from station.text.ladder_text import told
    from station.text.layout import answer

    opened = open_session(session, settings.sessions)
    refinement = open_refinement(opened, settings, model_file, effects_file, gain_percent, reset=reset)
    ladder = refinement.ladder
    if added:
        ladder = add(refinement, added)
    elif removed:
        ladder = remove(refinement, removed)
    elif auto:
        ladder = refine_to_floor(refinement, progress)
    elif number is not None:
        ladder = go_to(refinement, number)
    elif reset or model_file is not None or ladder.seen is None:
        ladder = write_ladder(opened, ladder)
    weighing = weighing_of(opened, settings, refinement.prepared.window.unit)
    document = ladder_document(opened, ladder)
    answer(as_json, document, told(ladder, weighing), *_next(opened, ladder), full=True)
    if not no_viewer:
        from station.operations import viewer_tabs

        if viewer_tabs.show_ladder(replace(refinement, ladder=ladder)):
            progress("the viewer shows the ladder: one tab a step")


def _next(session: "Session", ladder: "KeptLadder") -> tuple[str | Path, ...]:
    """Return the command that comes next: without what is of no use, to the report at the floor, else on."""
    if f"--remove {ladder.top.added}" in ladder.stopped_because:
        return ("refine", session.folder, "--remove", ladder.top.added)
    if ladder.top.at_floor:
        return ("report", session.folder)
    if ladder.verdict is None:
        return ("refine", session.folder, "--auto")
    return ("report", session.folder)
