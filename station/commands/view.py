"""`station view`: a session in the Rerun viewer, or as pictures where there is no screen."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from station.commands.options import SESSION, pass_settings
from station.output import json_option, print_json, progress, say
from station.settings import Settings
from station.text.next_step import next_line

if TYPE_CHECKING:
    from daq.session import Session
    from station.story.identification import Identification


@click.command("view")
@SESSION
@click.option(
    "--screenshot",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Write a picture of every tab into DIR; needs no screen.",
)
@click.option("--no-viewer", is_flag=True, help="Write the recording only.")
@json_option
@pass_settings
def command(
    settings: Settings, session: str, screenshot: Path | None, no_viewer: bool, as_json: bool
) -> None:
    """Open SESSION in the viewer: capture, alignment, both methods, results,
    and the steps of its refinement.

    Identifies it first, and keeps the recording in the session's results.
    """
    from station.operations.identifying import identify_session, kept_options, write_view
    from station.results.sessions import open_session

    opened = open_session(session, settings.sessions)
    result, _ = identify_session(opened, kept_options(opened, settings))
    from station.operations.viewer_tabs import kept_tabs

    file = write_view(opened, result, kept_tabs(opened, settings))
    document: dict[str, Any] = {"session": str(opened.folder), "recording": str(file), "pictures": []}
    progress(f"recording: {file}")
    if screenshot is not None:
        from station.views.photograph import photograph

        document["pictures"] = [str(picture) for picture in photograph(file, screenshot)]
        for picture in document["pictures"]:
            progress(f"picture:   {picture}")
    elif not no_viewer:
        open_if_possible(file)
    if as_json:
        print_json(document)
    else:
        say(next_line("report", opened.folder))


def show_session(session: "Session", result: "Identification") -> None:
    """Write the recording of an identification that is at hand, and open it where there is a screen."""
    from station.operations.identifying import write_view

    file = write_view(session, result)
    progress(f"recording: {file}")
    open_if_possible(file)


def open_if_possible(file: Path) -> None:
    """Open the viewer where there is a screen; say how to look at it where there is none."""
    from station.views import viewer

    if viewer.has_screen():
        viewer.open_viewer(file)
        progress("the viewer is opening")
    else:
        progress(f"no screen here: look at it elsewhere with `rerun {file}`, or take pictures with")
        progress(f"`station view {file.parent.parent} --screenshot DIR`")
