"""`station campaign`: hundreds of sessions, in one table with trends and control limits."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from station.commands.options import GAIN, known_places
from station.output import json_option, print_json, progress, screen

if TYPE_CHECKING:
    from station.campaign.crew import Crew
    from station.results.campaign_document import CampaignDocument

TABLE, TRENDS = "sessions.csv", "trends.csv"


@click.command("campaign")
@click.argument("sessions", nargs=-1, metavar="[FOLDER | SESSION...]", callback=known_places)
@click.option("--diagnose", is_flag=True, help="Diagnose each session too: seconds each.")
@click.option(
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Where results are kept (default: FOLDER/campaign).",
)
@click.option(
    "--metadata",
    type=click.Path(path_type=Path),
    metavar="CSV",
    help="Numbers known of the sessions, as temperatures.",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), metavar="N", help="Processes here (default: one a core)."
)
@click.option("--scheduler", metavar="ADDRESS", help="Use this Dask cluster instead, as tcp://host:8786.")
@GAIN
@json_option
@click.pass_obj
def command(
    settings_file: str | None,
    sessions: tuple[str, ...],
    diagnose: bool,
    output: Path | None,
    metadata: Path | None,
    workers: int | None,
    scheduler: str | None,
    gain_percent: float | None,
    as_json: bool,
) -> None:
    """Identify hundreds of sessions and look at them together.

    FOLDER holds sessions (default: ./sessions). Each result is kept as soon as
    it is there; a second run does what is missing or changed.
    """
    from station.campaign.kept import Kept
    from station.campaign.metadata import read_metadata
    from station.campaign.run import Request, run_campaign
    from station.campaign.sources import default_folder, find_sources
    from station.campaign.together import campaign_document
    from station.operations.identifying import NothingIdentified
    from station.settings import load_settings
    from station.text.campaign_progress import CampaignProgress
    from station.text.campaign_table import sessions_csv, trends_csv
    from station.text.campaign_text import show_campaign

    settings = load_settings(settings_file)
    known, notes = read_metadata(metadata) if metadata is not None else ({}, ())
    for note in notes:
        progress(note)
    kept = Kept(output or default_folder(sessions, settings))
    sources = find_sources(sessions, settings)
    unknown = len(set(known) - {source.name for source in sources})
    if unknown:
        progress(f"{unknown} of the {len(known)} sessions in {metadata} are not among these")
    watch = CampaignProgress(len(sources))
    request = Request(settings, gain_percent, diagnose)
    try:
        run = run_campaign(sources, request, _crew(workers, scheduler, len(sources)), kept, watch)
    except KeyboardInterrupt:
        watch.end()
        progress("what is done is kept, and the same command goes on with the rest")
        raise
    watch.end()
    document = campaign_document(kept.folder, diagnose, run, known)
    kept.write_table(document, {TABLE: sessions_csv(document), TRENDS: trends_csv(document)})
    if as_json:
        print_json(document.plain())
    else:
        show_campaign(screen(), document)
        folders = {source.name: source.folder for source in sources}
        for line in _next(document, folders, sessions):
            screen().print(line, markup=False, soft_wrap=True)
    if not document.rows:
        raise NothingIdentified(f"none of the {len(sources)} sessions has a result; the reasons are above")


def _next(document: "CampaignDocument", folders: dict[str, Path], given: tuple[str, ...]) -> list[str]:
    """Return the command that comes next: the session that lies farthest out, else a diagnosis of all."""
    from station.text.next_step import next_line

    outside = [one for chart in document.charts for one in chart.outside if one.session in folders]
    if outside:
        farthest = max(outside, key=lambda one: abs(one.sigmas or 0.0))
        return [next_line("diagnose", folders[farthest.session])]
    if document.rows and not document.diagnosed:
        return [next_line("campaign", "--diagnose", *given)]
    return []


def _crew(workers: int | None, scheduler: str | None, sessions: int) -> "Crew":
    from station.exits import UsageProblem

    if scheduler is not None:
        if workers is not None:
            raise UsageProblem("--workers is for this computer; a cluster has the workers that it has")
        from station.campaign.dask_crew import DaskCrew

        return DaskCrew(scheduler)
    from station.campaign.local_crew import LocalCrew, cores

    return LocalCrew(min(workers or cores(), sessions))
