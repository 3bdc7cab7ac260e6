"""`station replay`: a session's raw bytes through the same decoder and the same pipeline again."""

import click

from station.commands.options import NO_VIEWER, SESSION, pass_settings
from station.output import json_option
from station.settings import Settings


@click.command("replay")
@SESSION
@click.option(
    "--speed",
    type=click.FloatRange(min=0),
    default=0.0,
    show_default=True,
    help="Times real time; 0: as fast as it goes.",
)
@NO_VIEWER
@json_option
@pass_settings
def command(settings: Settings, session: str, speed: float, no_viewer: bool, as_json: bool) -> None:
    """Send SESSION's raw bytes through the decoder again, and identify it."""
    from daq.replay import replay
    from station.commands.capture import finish
    from station.operations.capturing import live_screen
    from station.results.sessions import open_session
    from station.text.capture_progress import Several, Watch

    opened = open_session(session, settings.sessions)
    with live_screen(opened.info.rate_hz or 0.0, not no_viewer) as screen, Watch() as watch:
        replay(opened, Several((watch, *screen.observers)), speed)
    finish(opened, screen.url, settings, as_json)
