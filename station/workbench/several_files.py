"""Several files of one logger that were dropped together: sessions by one recipe, and what a campaign says of them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from daq.importing.recipe import Recipe
from station.exits import UsageProblem
from station.settings import Settings
from station.workbench.parts import part
from station.workbench.view_models import Campaign
from station.workbench.worker import Say


class _Watch:
    """Tells how many sessions are done."""

    def __init__(self, total: int, say: Say) -> None:
        self._total, self._done, self._say = total, 0, say

    def kept(self, name: str, reason: str = "") -> None:
        self._done += 1
        self._say(f"{self._done} of {self._total} sessions identified")

    done = failed = kept


def import_files(
    settings: Settings,
    say: Say,
    files: Sequence[Path],
    recipe: Recipe,
    names: str,
    varies: str,
    mass: float | None,
) -> Campaign:
    """Import files by one recipe and run a campaign over their sessions; see `station campaign --recipe`.

    Raises UsageProblem where none of the files can be read.
    """
    from station.campaign.crew import InThisProcess
    from station.campaign.files import Names
    from station.campaign.files import import_files as sessions_of
    from station.campaign.kept import Kept
    from station.campaign.run import Request
    from station.campaign.sources import FOLDER, find_sources
    from station.campaign.together import campaign
    from station.operations.new_session import session_info
    from station.text.campaign_text import told
    from station.text.content import Paragraph

    info = session_info(settings, mass, None, None, None, (), varies.split(","))
    form = Names(names) if names.strip() else None
    lines: list[str] = []
    made = []
    for folder in sessions_of(files, settings.sessions, recipe, form, {}, info, lines.append):
        say(f"read as {folder.name}")
        made.append(str(folder))
    if not made:
        raise UsageProblem(f"none of the {len(files)} files could be read: {'; '.join(lines)}")
    sources = find_sources(tuple(made), settings)
    kept = Kept(settings.sessions / FOLDER)
    watch = _Watch(len(sources), say)
    found = told(campaign(sources, Request(settings), InThisProcess(), kept, watch))
    remarks = tuple(Paragraph(line) for line in lines)
    made_of = [source.name for source in sources]
    return Campaign(made_of, part("told", replace(found, brief=(*remarks, *found.brief))))
