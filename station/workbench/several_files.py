"""Several files of one logger that were dropped together: sessions by one recipe, and what a campaign says of them."""

from collections.abc import Sequence
from io import StringIO
from pathlib import Path

from daq.importing.recipe import Recipe
from station.exits import UsageProblem
from station.settings import Settings
from station.story.pipeline import Progress
from station.workbench.view_models import Campaign


class _Watch:
    """Tells how many sessions are done."""

    def __init__(self, total: int, progress: Progress) -> None:
        self._total, self._done, self._progress = total, 0, progress

    def kept(self, name: str, reason: str = "") -> None:
        self._done += 1
        self._progress(f"{self._done} of {self._total} sessions identified")

    done = failed = kept


def import_files(
    settings: Settings,
    progress: Progress,
    files: Sequence[Path],
    recipe: Recipe,
    names: str,
    varies: str,
    mass: float | None,
) -> Campaign:
    """Import files by one recipe and run a campaign over their sessions; see `station campaign --recipe`.

    Raises UsageProblem where none of the files can be read.
    """
    from rich.console import Console

    from station.campaign.crew import InThisProcess
    from station.campaign.files import Names
    from station.campaign.files import import_files as sessions_of
    from station.campaign.kept import Kept
    from station.campaign.run import Request
    from station.campaign.sources import FOLDER, find_sources
    from station.campaign.together import campaign
    from station.operations.new_session import session_info
    from station.text.campaign_text import told
    from station.text.layout import show

    info = session_info(settings, mass, None, None, None, (), varies.split(","))
    form = Names(names) if names.strip() else None
    lines: list[str] = []
    made = []
    for folder in sessions_of(files, settings.sessions, recipe, form, {}, info, lines.append):
        progress(f"read as {folder.name}")
        made.append(str(folder))
    if not made:
        raise UsageProblem(f"none of the {len(files)} files could be read: {'; '.join(lines)}")
    sources = find_sources(tuple(made), settings)
    kept = Kept(settings.sessions / FOLDER)
    watch = _Watch(len(sources), progress)
    document = campaign(sources, Request(settings), InThisProcess(), kept, watch)
    page = StringIO()
    show(Console(file=page, width=80, highlight=False, color_system=None), told(document))
    return Campaign([source.name for source in sources], "\n".join([*lines, page.getvalue().strip("\n")]))
