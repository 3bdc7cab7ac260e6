"""The tasks of a worker that make sessions: of an example, or of dropped files, several of one logger by one recipe."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from daq.importing.apply import matched
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.reading import read_table
from daq.importing.recipe import Recipe
from daq.session_info import SessionInfo
from station.campaign import sources as campaign_sources
from station.campaign.sources import FOLDER, find_sources
from station.campaign.together import campaign
from station.exits import UsageProblem
from station.operations import examples
from station.operations.new_session import session_info
from station.operations.workers import Say, on_the_page
from station.results.kept_recipes import look_with_kept
from station.results.sessions import import_file
from station.settings import Settings
from station.text.campaign_text import told
from station.text.content import Paragraph
from station.workbench.parts import part
from station.workbench.session_list import outline
from station.workbench.view_models import Numbers


@dataclass(frozen=True)
class AskedColumn:
    """A column of a file: what it is called, its first numbers, and all of it as a line of few."""

    place: str
    numbers: str
    line: Numbers


@dataclass(frozen=True)
class ImportQuestion:
    """What is to be said of a file: a sentence, the recipe that is proposed, and a column for each of its fields."""

    sentence: str
    recipe: Recipe
    columns: tuple[AskedColumn, ...]


@dataclass(frozen=True)
class Imported:
    """What came of files: the names of the sessions, and what is told of them: of several, a campaign as HTML."""

    sessions: list[str]
    told: str


def open_example(settings: Settings, say: Say, name: str) -> str:
    """Import a recording that comes with the station, unless it is there already; return its session's name."""
    return examples.open_example(name, settings.sessions).folder.name


def import_files(
    settings: Settings,
    say: Say,
    files: Sequence[Path],
    mass: float | None,
    ask: bool,
    recipe: Recipe | None = None,
    names: str = "",
    varies: str = "",
) -> Imported | ImportQuestion:
    """Import files; return what came of it, or what is to be said of the first before.

    Several are read by one `recipe`, with numbers in their `names` and what `varies`, as `station campaign --recipe` does.
    Raises UsageProblem where none of several can be read.
    """
    first, *others = files
    say(f"reading {first.name}")
    info = session_info(settings, mass, varies=varies.split(","))
    try:
        if recipe is None and (ask or others):
            known = look_with_kept(first, settings.sessions, ImportOptions())[0].read().recipe
            return _question(first, known, "what the columns seem to be")
        if recipe is not None and others:
            return _campaign(settings, say, files, recipe, names, info)
        made = import_file(first, None, settings.sessions, ImportOptions(), info, recipe)
    except Doubtful as refusal:
        doubts = (doubt.partition("; ")[0] for doubt in refusal.proposal.doubts)  # what to do is on the page
        return _question(first, refusal.proposal.recipe, "; ".join(doubts))
    sessions = [session.folder.name for session in made.sessions]
    more = [f"its other releases: {', '.join(sessions[1:])}"] if sessions[1:] else []
    notes = [on_the_page(note) for note in made.notes]
    if notes != list(made.notes):
        notes.append("where that is wrong, tick Show the columns first and drop the file again")
    return Imported(sessions, "; ".join([*notes, *more]))


def _question(file: Path, recipe: Recipe, sentence: str) -> ImportQuestion:
    table = read_table(file, recipe)
    found = {id(field): number for number, field in matched(table, recipe).items()}
    columns = {column.number: column for column in table.columns}
    asked = []
    for field in recipe.fields:
        column = columns[found[id(field)]]
        first = ", ".join(f"{value:.5g}" for value in column.values[:4])
        asked.append(AskedColumn(column.place, first, outline(column.values)[1]))
    return ImportQuestion(f"{file.name}: {sentence}", recipe, tuple(asked))


def _campaign(
    settings: Settings, say: Say, files: Sequence[Path], recipe: Recipe, names: str, info: SessionInfo
) -> Imported:
    form = campaign_sources.Names(names) if names.strip() else None
    lines: list[str] = []
    made = []
    for folder in campaign_sources.import_files(
        files, settings.sessions, recipe, form, {}, info, lines.append
    ):
        say(f"read as {folder.name}")
        made.append(str(folder))
    if not made:
        raise UsageProblem(f"none of the {len(files)} files could be read: {'; '.join(lines)}")
    sources = find_sources(tuple(made), settings)
    ready: list[str] = []

    def watch(name: str, reason: str) -> None:
        ready.append(name)
        say(f"{len(ready)} of {len(sources)} sessions identified")

    found = told(campaign(sources, settings, settings.sessions / FOLDER, workers=0, watch=watch))
    remarks = tuple(Paragraph(on_the_page(line)) for line in lines)
    return Imported(
        [source.folder.name for source in sources],
        part("told", replace(found, brief=(*remarks, *found.brief))),
    )
