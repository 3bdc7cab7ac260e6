"""`station report`: one page about a session, to attach to a test report."""

from pathlib import Path

import click

from station.commands.options import JSON, SESSION, declared, option
from station.output import next_line, print_json, progress, say
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
    as_json: bool = JSON,
) -> None:
    """Write all that is known of SESSION into one HTML page.

    It needs nothing outside itself, prints to PDF through the browser, and
    says what was left out and why. Identifies and compares on the way.
    """
    from station.report.write import write_report
    from station.results.sessions import open_session

    opened = open_session(session, settings.sessions)
    report = write_report(opened, output, settings=settings, progress=progress)
    if as_json:
        print_json(
            {"session": opened.folder.name, "report": str(report.path.resolve()), "left_out": report.left_out}
        )
    else:
        say(f"report: {report.path}")
        for name, reason in sorted(report.left_out.items()):
            say(f"left out: {name.replace('_', ' ')}: {reason}")
        if not with_browser:
            say(next_line("report", session, "--open"))
    if with_browser:
        import webbrowser

        if not webbrowser.open(report.path.resolve().as_uri()):
            progress(f"no browser here: open {report.path} elsewhere")
