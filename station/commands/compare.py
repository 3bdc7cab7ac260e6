"""`station compare`: by how much a model fails on a session, and where."""

from pathlib import Path

import click

from station.commands.options import EFFECTS, FULL, MASS_INSTEAD, MODEL, SESSION
from station.output import json_option, print_json, progress, screen


@click.command("compare")
@SESSION
@MODEL
@EFFECTS
@MASS_INSTEAD
@FULL
@click.option("--view", "with_view", is_flag=True, help="Write the Compare tab for the viewer, and open it.")
@json_option
@click.pass_obj
def command(
    settings_file: str | None,
    session: str,
    model_file: Path | None,
    effects_file: Path | None,
    mass: float | None,
    full: bool,
    with_view: bool,
    as_json: bool,
) -> None:
    """Compare a model with SESSION: how large its errors are, and where.

    The residual beside the noise, a sensor or physics, the worst places in
    words; --full adds noise, cycles and harmonics. Without --model it is the session's current
    model: the refined one, and before any `refine` the one that it begins with.
    """
    from station.operations.comparing import compare_session, write_view
    from station.results.sessions import open_session
    from station.settings import load_settings

    settings = load_settings(settings_file)
    opened = open_session(session, settings.sessions)
    compared, document = compare_session(opened, settings, model_file, effects_file, mass=mass)
    if as_json:
        print_json(document.plain())
    else:
        from station.text.comparison_text import show_comparison
        from station.text.next_step import next_line

        show_comparison(screen(), compared, full=full)
        fails = not compared.judged.at_floor
        screen().print(
            next_line("diagnose" if fails else "report", opened.folder), markup=False, soft_wrap=True
        )
    if with_view:
        from station.commands.view import open_if_possible

        file = write_view(opened, compared)
        progress(f"recording: {file}")
        open_if_possible(file)
