"""The viewer's recording of a session: kept in its results, and shown in a viewer that is open."""

from pathlib import Path
from tempfile import TemporaryDirectory

from daq.session import Session
from identify.fitting.fit import Fit
from station.exits import UsageProblem
from station.operations.identifying import identify_session
from station.operations.refining import Refinement, open_refinement, step_again
from station.output import progress
from station.results.ladder import LADDER, KeptLadder
from station.settings import Settings
from station.story.pipeline import Identification

VIEW = "identification.rrd"


def write_view(
    session: Session,
    result: Identification,
    settings: Settings,
    refinement: Refinement | None = None,
    *,
    dark: bool = True,
) -> Path:
    """Write the tabs of the viewer into the session's results, with the steps where it was refined."""
    from station.views import tabs

    steps = _steps(session, settings, refinement)
    with TemporaryDirectory() as folder:
        file = Path(folder) / VIEW
        tabs.write(file, session.folder.name, result, steps, dark=dark)
        return session.write_result(VIEW, file.read_bytes())


def show_refined(refinement: Refinement, settings: Settings, port: int | None = None) -> None:
    """Show a session anew after a step, in the viewer that is open at a port (default: Rerun's own); none is opened."""
    from station.views import viewer

    port = port or viewer.PORT
    if viewer.answers(port):
        result, _ = identify_session(refinement.session, settings)
        viewer.show(write_view(refinement.session, result, settings, refinement), port)
        progress("the viewer shows the ladder: one tab a step")


def _steps(
    session: Session, settings: Settings, refinement: Refinement | None
) -> tuple[KeptLadder, tuple[Fit, ...]] | None:
    """Fit the steps up to the present one again from their values; None where the session was not refined."""
    if not (session.results / LADDER).is_file():
        return None
    try:
        opened = refinement or open_refinement(session, settings)
    except UsageProblem as problem:  # an effect of the user's own file, which is not at hand here
        progress(f"the tab Ladder is left out: {problem}")
        return None
    kept = opened.ladder
    return kept, tuple(step_again(opened, step).fit for step in kept.steps[: kept.present + 1])
