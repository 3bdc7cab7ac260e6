"""`station workbench`: one page on which the loop is closed with a mouse."""

from pathlib import Path

import click

from station.commands.options import pass_settings
from station.output import progress
from station.settings import Settings


@click.command("workbench")
@click.argument("sessions", nargs=-1, metavar="[SESSION]...")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, metavar="N", help="Port (default: a free one)."
)
@click.option(
    "--host",
    default="127.0.0.1",
    metavar="ADDRESS",
    help="Let other computers in; whoever has the address with its token can use the page.",
)
@click.option("--no-browser", is_flag=True, help="Do not open the browser.")
@pass_settings
def command(settings: Settings, sessions: tuple[str, ...], port: int, host: str, no_browser: bool) -> None:
    """Serve a page on which sessions are captured, compared, diagnosed and refined.

    SESSION is a session or a data file; without one the page offers those in
    ./sessions. The page answers on 127.0.0.1 only, and only to who has the
    address that is printed: it holds a token.
    """
    from station.results.sessions import open_session
    from station.workbench.server import serve

    settings = settings.model_copy(update={"sessions": settings.sessions.resolve()})
    named: tuple[Path, ...] = tuple(open_session(name, settings.sessions).folder for name in sessions)
    if host != "127.0.0.1":
        progress(
            f"other computers that reach {host} can use this page by the address below; nothing on the way is encrypted"
        )
    serve(settings, named, host, port, not no_browser, progress)
