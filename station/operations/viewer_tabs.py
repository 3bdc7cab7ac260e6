"""The viewer's recording of a session, and its Ladder tab, there and in a viewer that is open."""

import time
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from daq.session import Session
from station.exits import UsageProblem
from station.operations.refining import Refinement, open_refinement, step_again
from station.output import progress
from station.results.ladder import LADDER
from station.settings import Settings
from station.story.identification import Identification

if TYPE_CHECKING:
    from station.views.log import Tab


VIEW = "identification.rrd"


def write_view(session: Session, result: Identification, settings: Settings, *, dark: bool = True) -> Path:
    """Write the tabs of the viewer into the session's results: those of the identification, and the ladder's."""
    from station.views import show

    tabs = kept_tabs(session, settings)
    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        show.write(file, session.folder.name, result, tabs, dark=dark)
        return session.write_result(VIEW, file.read_bytes())


def ladder_tab(refinement: Refinement, root: str = "/ladder") -> "Tab":
    """Make the Ladder tab of a session; each step's fit is found again from its values."""
    from station.views import ladder

    kept, name = refinement.ladder, refinement.session.folder.name
    fits = tuple(step_again(refinement, step).fit for step in kept.steps[: kept.present + 1])
    return partial(ladder.tab, name=name, ladder=kept, fits=fits, weighing=refinement.weighing, root=root)


def kept_tabs(session: Session, settings: Settings) -> tuple["Tab", ...]:
    """Return the Ladder tab where the session was refined."""
    if not (session.results / LADDER).is_file():
        return ()
    try:
        return (ladder_tab(open_refinement(session, settings)),)
    except UsageProblem as problem:  # an effect of the user's own file, which is not at hand here
        progress(f"the tab Ladder is left out: {problem}")
        return ()


def show_ladder(refinement: Refinement, at: str | None = None) -> bool:
    """Show the ladder in the viewer `at` a URL, else in the one that is open, or in a new one; False where there is none.

    Every call draws under a path of its own, since what a viewer has drawn of a step before may differ.
    """
    from station.views.viewer import url_or_new

    url = at or url_or_new()
    if url is None:
        return False
    from station.views import show

    tab = ladder_tab(refinement, f"/ladder/{time.time_ns()}")
    show.send_tab(url, f"{refinement.session.folder.name}-model", tab)
    return True
