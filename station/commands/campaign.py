"""`station campaign`: identify hundreds of sessions; trends, control limits."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from station.commands.options import VARIES, argument, declared, option
from station.output import progress
from station.settings import Settings

if TYPE_CHECKING:
    from station.campaign.metadata import Known
    from station.campaign.run import Watch
    from station.results.campaign_document import CampaignDocument


A_FOLDER = click.Path(path_type=Path, file_okay=False)


@declared("campaign")
def command(
    settings: Settings,
    sessions: tuple[str, ...] = argument(nargs=-1, metavar="[FOLDER | SESSION...]"),
    diagnose: bool = option("Diagnose each session too: seconds each."),
    output: Path | None = option(
        "Where results are kept (default: FOLDER/campaign).",
        type=A_FOLDER,
        metavar="FOLDER",
    ),
    metadata: Path | None = option("Numbers known of the sessions or files, as temperatures.", metavar="CSV"),
    recipe: Path | None = option("Import the files of FOLDER by this recipe.", metavar="FILE"),
    ask: bool = option("Open the recipe of the first file in your editor, for all."),
    names: str | None = option('What the names of files say, as "{arm:d}P.txt".', metavar="PATTERN"),
    varies: tuple[str, ...] = VARIES,
    workers: int | None = option(
        "Processes here (default: one a core).", type=click.IntRange(1, 1024), metavar="N"
    ),
) -> None:
    """Identify hundreds of sessions and look at them together.

    FOLDER holds sessions (default: ./sessions), or files of one logger, which
    are imported first. Each result is kept as soon as it is there; a second run
    does what is missing or changed.
    """
    from station.campaign.metadata import read_metadata
    from station.campaign.run import cores
    from station.campaign.sources import FOLDER, default_folder, find_sources, is_folder_of_files
    from station.campaign.together import campaign, names_known
    from station.exits import Answered
    from station.results.session_names import session_folder
    from station.text import campaign_text
    from station.text.layout import answer

    what, place = "folder, session or data file", settings.sessions
    sessions = tuple(one if one == str(place) else str(session_folder(one, place, what)) for one in sessions)
    known, notes = read_metadata(metadata) if metadata is not None else ({}, ())
    for note in notes:
        progress(note)
    if recipe or ask or names or varies or (len(sessions) == 1 and is_folder_of_files(sessions[0])):
        place, folders = _imported(sessions, settings, (recipe, ask, names, varies), metadata, known)
        given: tuple[str, ...] = (str(place),)
        sessions = tuple(map(str, folders))
        kept = output or place / FOLDER
    else:
        given, kept = sessions, output or default_folder(sessions, settings)
    sources = find_sources(sessions, settings)
    names_of = (name for source in sources for name in names_known(source))
    if unknown := len(set(known).difference(names_of)):
        progress(f"{unknown} of the {len(known)} sessions in {metadata} are not among these")
    processes = min(workers or cores(), len(sources))
    try:
        with _watched(len(sources)) as watch:
            document = campaign(sources, settings, kept, processes, watch, known, diagnose=diagnose)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            "interrupted; finished sessions are kept, and the same command continues with the rest"
        ) from None
    folders_of = {source.folder.name: source.folder for source in sources}
    step = _next(document, folders_of, given)
    answer(document.plain(), campaign_text.told(document), *step)
    if not document.rows:
        raise Answered(f"none of the {len(sources)} sessions has a result; the reasons are above")


def _imported(
    arguments: tuple[str, ...],
    settings: Settings,
    said: tuple[Path | None, bool, str | None, tuple[str, ...]],
    metadata: Path | None,
    known: "dict[str, Known]",
) -> tuple[Path, list[Path]]:
    """Import the files of a folder; return where their sessions are, and each."""
    from daq.importing.options import ImportOptions
    from daq.importing.propose import Doubtful
    from daq.importing.recipe import read_recipe, to_toml
    from station.campaign.sources import Names, files_in, import_files
    from station.exits import UsageProblem
    from station.operations.new_session import session_info
    from station.results.kept_recipes import asked
    from station.safe_text import harmless

    recipe, ask, names, varies = said
    if len(arguments) != 1 or not Path(arguments[0]).is_dir() or (recipe and ask):
        raise UsageProblem(
            "--recipe, --ask, --names and --varies are for one FOLDER of files; give --recipe or --ask"
        )
    folder = Path(arguments[0])
    files = files_in(folder, (recipe, metadata))
    form = Names(names) if names else None
    meant = [file for file in files if form is None or form.said(file.name)]
    if not meant:
        raise UsageProblem(f"{folder}: no file in it{f' is of the form {names}' if names else ''}")
    given = (
        read_recipe(recipe)
        if recipe
        else asked(meant[0], ImportOptions(), settings.sessions)
        if ask
        else None
    )
    place = settings.sessions / (folder.resolve().name or "files")
    info = session_info(settings, varies=varies)
    try:
        made = list(import_files(files, place, given, form, known, info, progress, settings.sessions))
    except Doubtful as refusal:
        click.echo(harmless(to_toml(refusal.proposal.recipe)))
        raise UsageProblem(
            f"{refusal}. In a terminal --ask opens the recipe in your editor; or write the recipe above into a file, "
            "correct it, and give that by --recipe"
        ) from refusal
    if not made:
        raise UsageProblem(f"{folder}: none of its {len(files)} files could be read; the reasons are above")
    return place, made


def _next(
    document: "CampaignDocument", folders: dict[str, Path], given: tuple[str, ...]
) -> tuple[str | Path, ...]:
    """Return the command that comes next: the session that lies farthest out, else a diagnosis of all."""
    outside = [one for chart in document.charts for one in chart.outside if one.session in folders]
    if outside:
        farthest = max(outside, key=lambda one: abs(one.sigmas or 0.0))
        return ("diagnose", folders[farthest.session])
    if document.rows and not document.diagnosed:
        return ("campaign", "--diagnose", *given)
    return ()


@contextmanager
def _watched(total: int) -> Iterator["Watch"]:
    """Show in a terminal how many sessions are done and how long the rest takes; say of each that failed why."""
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from station.safe_text import SafeConsole

    columns = (MofNCompleteColumn(), TextColumn("sessions"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=SafeConsole(stderr=True, highlight=False), transient=True) as bar:
        task = bar.add_task("", total=total)

        def watch(name: str, reason: str) -> None:
            bar.advance(task)
            if reason:
                progress(f"failed: {name}: {reason}")

        yield watch
