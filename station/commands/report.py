"""`station report`: write all that is known of a session into one page."""

from pathlib import Path

import click

from station.commands.options import SESSION, declared, option
from station.output import progress
from station.settings import Settings

NO_FOLDER = click.Path(path_type=Path, dir_okay=False)


@declared("report")
def command(
    settings: Settings,
    session: str = SESSION,
    output: Path | None = option(
        "Where to write it (default: results/report.html in the session).",
        type=NO_FOLDER,
        metavar="FILE",
    ),
    with_browser: bool = option("Open it in the browser.", "--open"),
) -> None:
    """Write all that is known of SESSION into one HTML page.

    It needs nothing outside itself, prints to PDF through the browser, and
    says what was left out and why. Identifies and compares on the way.
    """
    from station.report.write import write_report
    from station.results.sessions import open_session
    from station.text.content import Table, Told, facts
    from station.text.layout import answer

    opened = open_session(session, settings.sessions)
    report, left_out = write_report(opened, output, settings=settings, progress=progress)
    path = Table("", ("",), ((f"report: {report}",),), texts=1)
    rows = [("left out", f"{name.replace('_', ' ')}: {why}") for name, why in sorted(left_out.items())]
    document = {
        "session": opened.folder.name,
        "report": str(report.resolve()),
        "left_out": left_out,
    }
    answer(
        document, Told("", "", (path, *facts(rows))), *(() if with_browser else ("report", session, "--open"))
    )
    if with_browser:
        import webbrowser

        if not webbrowser.open(report.resolve().as_uri()):
            progress(f"no browser here: open {report} elsewhere")
