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
    from station.campaign.files import Names
    from station.campaign.files import import_files as sessions_of
    from station.campaign.sources import FOLDER, Request, find_sources
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
    done: list[str] = []

    def watch(name: str, reason: str) -> None:
        done.append(name)
        say(f"{len(done)} of {len(sources)} sessions identified")

    found = told(campaign(sources, Request(settings), settings.sessions / FOLDER, workers=0, watch=watch))
    remarks = tuple(Paragraph(line) for line in lines)
    made_of = [source.folder.name for source in sources]
    return Campaign(made_of, part("told", replace(found, brief=(*remarks, *found.brief))))
