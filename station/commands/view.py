"""`station view`: a session in the Rerun viewer."""

from station.commands.options import NO_VIEWER, SESSION, declared
from station.output import progress
from station.settings import Settings


@declared("view")
def command(settings: Settings, session: str = SESSION, no_viewer: bool = NO_VIEWER) -> None:
    """Open SESSION in the viewer: capture, alignment, both methods, results,
    and the steps of its refinement.

    Identifies it first, and keeps the recording in the session's results.
    """
    from station.operations.identifying import identify_session
    from station.operations.viewer_tabs import write_view
    from station.results.sessions import open_session
    from station.text.content import Told
    from station.text.layout import answer
    from station.views import viewer

    opened = open_session(session, settings.sessions)
    opened.require_writable()
    result, _ = identify_session(opened, settings)
    file = write_view(opened, result, settings)
    progress(f"recording: {file}")
    if not no_viewer and viewer.has_screen():
        viewer.start(str(file), "--port", "auto")
        progress("the viewer is opening")
    elif not no_viewer:
        progress(f"no screen here: look at it elsewhere with `rerun {file}`")
    document = {"session": str(opened.folder), "recording": str(file)}
    answer(document, Told("", "", ()), "report", opened.folder)
