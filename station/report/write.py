"""The report of a session, a page that needs nothing outside itself; and a guided test on the screen, which writes one."""

from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path

from daq.session import Session
from daq.storage import write_whole
from station.campaign.sources import FOLDER, find_sources
from station.campaign.together import campaign
from station.operations.guiding import GuidedTest, guide
from station.output import asked_for_json, progress as say, screen
from station.report.findings import Findings, gather
from station.report.first_page import first_page
from station.report.loop import comparison, equation, ladder, methods, suspects
from station.report.measurement import provenance, setup
from station.results.guide_document import NAME as GUIDE, GuideDocument
from station.safe_text import SafeConsole
from station.settings import Settings
from station.story.pipeline import Progress, silent
from station.text.content import left_out
from station.text.guide_text import GuideScreen, show_guide
from station.views.figure import inked
from station.views.palette import LIGHT

NAME = "report.html"
SECTIONS = (
    ("comparison", "The current model, compared with the measurement", comparison),
    ("suspects", "Suspects: which effect is missing", suspects),
    ("ladder", "The ladder: the residual, step by step", ladder),
    ("equation", "The equation of motion", equation),
    ("setup", "Set-up, calibration, and verdict on the recording", setup),
    ("methods", "Appendix: alignment of the channels, and identification by two methods", methods),
    ("provenance", "Software and checksums", provenance),
)
"""The anchor of each, its title, and what makes its parts: none where it is left out."""

RESTS_ON = {"equation": "comparison", "methods": "identification"}
"""By whose reason a section is left out that has none of its own."""


def write_report(
    session: Session,
    output: Path | None = None,
    *,
    settings: Settings | None = None,
    progress: Progress = silent,
) -> tuple[Path, dict[str, str]]:
    """Write the report of a session, to results/report.html unless `output` says otherwise.

    Returns where it is, and the reason of each section that was left out.

    Identifies and compares on the way. Raises DataLost when the session holds no sample, StorageError when the disk
    refuses.
    """
    found = gather(session, settings or Settings(), progress)
    progress("drawing the page")
    page = rendered(found).encode()
    if output is None:
        return session.write_result(NAME, page), found.left_out
    write_whole(output, page)
    return output, found.left_out


def rendered(found: Findings) -> str:
    """Return the page; every text in it is escaped, whoever wrote it."""
    from jinja2 import Environment, StrictUndefined

    with inked(LIGHT):
        front, made = first_page(found), {name: make(found) for name, _, make in SECTIONS}
    sections = [
        (name, title, made[name] or [left_out(found.left_out[RESTS_ON.get(name, name)])])
        for name, title, _ in SECTIONS
    ]
    template = files("station.report").joinpath("page.html").read_text(encoding="utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    return environment.from_string(template).render(
        session=found.session.folder.name,
        info=found.session.info,
        made=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        front=front,
        sections=sections,
        left_out=sorted(found.left_out.items()),
    )


def finish_guided(test: GuidedTest, document: GuideDocument) -> GuideDocument:
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
    report, _ = write_report(session, test.folder / NAME, settings=test.settings)
    whole = document.model_copy(update={"report": str(report), "campaign": str(kept)})
    write_whole(test.folder / GUIDE, whole.model_dump_json(indent=1).encode() + b"\n")
    return whole


def show_guided(test: GuidedTest) -> GuideDocument:
    """Run a guided test on the screen (on stderr where JSON is wanted); return its document."""
    console = SafeConsole(stderr=True, highlight=False) if asked_for_json() else screen()
    document = guide(test, GuideScreen(console, alone=test.alone))
    say("writing the report")
    document = finish_guided(test, document)
    show_guide(console, document)
    return document
