"""`station validate`: what a model predicts of sessions that it was not fitted to."""

from pathlib import Path

import click

from station.commands.options import EFFECTS, SESSIONS, VARIES, existing, pass_settings
from station.output import json_option, progress
from station.settings import Settings


@click.command("validate")
@click.argument("model", callback=existing("model file or session"))
@SESSIONS
@EFFECTS
@VARIES
@click.option("--hold", is_flag=True, help="Hold the linear spring and the viscous part too.")
@json_option
@pass_settings
def command(
    settings: Settings,
    model: str,
    sessions: tuple[str, ...],
    effects_file: Path | None,
    varies: tuple[str, ...],
    hold: bool,
    as_json: bool,
) -> None:
    """Say how well a model predicts sessions that it was not fitted to.

    MODEL is a model file, or a session that was refined or diagnosed. Its
    physics is held; start, zero, lag, gain and offsets of each SESSION are
    refitted, and the linear spring and viscous part within 1 % and 100 %;
    what --varies says was changed is each SESSION's own.
    The usual model predicts under the same rule.
    """
    from station.operations.validating import validate_sessions
    from station.text.layout import answer
    from station.text.validation_text import told

    document = validate_sessions(
        model, sessions, settings, effects_file, hold=hold, varies=varies, progress=progress
    )
    better = document.verdict == "predicts_better"
    step = ("report", sessions[0]) if better else ("diagnose", *sessions)
    answer(as_json, document.plain(), told(document), *step)
