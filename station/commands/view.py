"""`station view`: a session in the Rerun viewer, or as pictures where there is no screen."""

from pathlib import Path
from typing import Any

from station.commands.options import JSON, NO_VIEWER, SESSION, declared, option
from station.output import next_line, print_json, progress, say
from station.settings import Settings


@declared("view")
def command(
    settings: Settings,
    session: str = SESSION,
    screenshot: Path | None = option(
        "Write a picture of every tab into DIR; needs no screen.", metavar="DIR"
    ),
    no_viewer: bool = NO_VIEWER,
    as_json: bool = JSON,
) -> None:
    """Open SESSION in the viewer: capture, alignment, both methods, results,
    and the steps of its refinement.

    Identifies it first, and keeps the recording in the session's results.
    """
    from station.operations.identifying import identify_session, kept_options, write_view
    from station.operations.viewer_tabs import kept_tabs
    from station.results.sessions import open_session
    from station.views import viewer

    opened = open_session(session, settings.sessions)
    opened.require_writable()
    result, _ = identify_session(opened, kept_options(opened, settings))
    file = write_view(opened, result, kept_tabs(opened, settings))
    document: dict[str, Any] = {"session": str(opened.folder), "recording": str(file), "pictures": []}
    progress(f"recording: {file}")
    if screenshot is not None:
        from station.views.photograph import photograph

        document["pictures"] = [str(picture) for picture in photograph(file, screenshot)]
        for picture in document["pictures"]:
            progress(f"picture:   {picture}")
    elif not no_viewer and viewer.has_screen():
        viewer.start(str(file), "--port", "auto")
        progress("the viewer is opening")
    elif not no_viewer:
        progress(f"no screen here: look at it elsewhere with `rerun {file}`, or take pictures with")
        progress(f"`station view {opened.folder} --screenshot DIR`")
    if as_json:
        print_json(document)
    else:
        say(next_line("report", opened.folder))
