"""The documents at the end of a guided test: one report, and one campaign of all its releases."""

from daq.session import Session
from daq.storage import write_whole
from station.campaign.sources import FOLDER, find_sources
from station.campaign.together import campaign
from station.operations.guiding import GuidedTest, guide
from station.output import asked_for_json, progress, screen
from station.report.write import NAME as REPORT, write_report
from station.results.guide_document import NAME, GuideDocument
from station.safe_text import SafeConsole
from station.text.guide_text import GuideScreen, show_guide


def finish(test: GuidedTest, document: GuideDocument) -> GuideDocument:
    """Write the report of a guided test and the campaign of its sessions; return the document with their places.

    The report is that of the largest release, which keeps the diagnosis of all. Nothing is written where none was judged.
    """
    judged = [turn for turn in document.turns if turn.verdict]
    if not judged:
        return document
    kept = test.folder / FOLDER
    sources = find_sources((str(test.folder),), test.settings)
    campaign(sources, test.settings, kept, workers=0)
    largest = max(judged, key=lambda turn: abs(turn.amplitude or 0.0))
    session = Session.open(test.folder / largest.session)
    report, _ = write_report(session, test.folder / REPORT, settings=test.settings)
    whole = document.model_copy(update={"report": str(report), "campaign": str(kept)})
    write_whole(test.folder / NAME, whole.model_dump_json(indent=1).encode() + b"\n")
    return whole


def show_guided(test: GuidedTest) -> GuideDocument:
    """Run a guided test on the screen (on stderr where JSON is wanted); return its document."""
    console = SafeConsole(stderr=True, highlight=False) if asked_for_json() else screen()
    document = guide(test, GuideScreen(console, alone=test.alone))
    progress("writing the report")
    document = finish(test, document)
    show_guide(console, document)
    return document
