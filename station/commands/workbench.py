"""`station workbench`: open the page on which all of this is done by mouse."""

from pathlib import Path

import click

from station.commands.options import argument, declared, option
from station.output import progress
from station.settings import Settings


@declared("workbench", reports=False)
def command(
    settings: Settings,
    sessions: tuple[str, ...] = argument(nargs=-1, metavar="[SESSION]..."),
    port: int = option("Port (default: a free one).", type=click.IntRange(0, 65535), default=0, metavar="N"),
    host: str = option(
        "Let other computers in; whoever has the address with its token can use the page.",
        default="127.0.0.1",
        metavar="ADDRESS",
    ),
    no_browser: bool = option("Do not open the browser."),
) -> None:
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
    serve(settings, named, host, port, not no_browser)
