"""`station replay`: send a session's raw bytes through the decoder again."""

import click

from station.commands.options import NO_VIEWER, SESSION, declared, option
from station.settings import Settings


@declared("replay")
def command(
    settings: Settings,
    session: str = SESSION,
    speed: float = option(
        "Speed in multiples of real time; 0: as fast as possible.",
        type=click.FloatRange(min=0),
        default=0.0,
        show_default=True,
    ),
    no_viewer: bool = NO_VIEWER,
) -> None:
    """Send SESSION's raw bytes through the decoder again, and identify it."""
    from daq.replay import replay
    from station.commands.capture import finish
    from station.operations.capturing import live_screen
    from station.results.sessions import open_session
    from station.text.capture_progress import Watch

    opened = open_session(session, settings.sessions)
    with live_screen(opened.info.rate_hz or 0.0, not no_viewer) as (shown_at, live), Watch(live) as watch:
        replay(opened, watch, speed)
    finish(opened, shown_at, settings)
