"""`station report`: one page about a session, to attach to a test report."""

from pathlib import Path

import click

from station.commands.options import MASS_INSTEAD, SESSION, pass_settings
from station.output import json_option, print_json, progress, say
from station.settings import Settings
from station.text.next_step import next_line


@click.command("report")
@SESSION
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Where to write it (default: results/report.html in the session).",
)
@MASS_INSTEAD
@click.option("--diagnose", is_flag=True, help="Diagnose first (takes some seconds).")
@click.option("--open", "with_browser", is_flag=True, help="Open it in the browser.")
@json_option
@pass_settings
def command(
    settings: Settings,
    session: str,
    output: Path | None,
    mass: float | None,
    diagnose: bool,
    with_browser: bool,
    as_json: bool,
) -> None:
    """Write all that is known of SESSION into one HTML page.

    It needs nothing outside itself, prints to PDF through the browser, and
    says what was left out and why. Identifies and compares on the way.
    """
    from station.report.write import write_report
    from station.results.sessions import open_session

    opened = open_session(session, settings.sessions)
    report = write_report(opened, output, settings=settings, mass=mass, diagnose=diagnose, progress=progress)
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
