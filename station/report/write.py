"""Write the report of a session: a page that needs nothing outside itself."""

from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path

from daq.session import Session
from daq.storage import write_whole
from station.report.findings import Findings, gather
from station.report.first_page import first_page
from station.report.loop import comparison, equation, ladder, methods, suspects
from station.report.measurement import alignment, capture, provenance, setup
from station.settings import Settings
from station.story.pipeline import Progress, silent
from station.text.content import left_out
from station.views.figure import inked
from station.views.palette import PAPER

NAME = "report.html"
SECTIONS = (
    ("comparison", "The current model, compared with the measurement", comparison),
    ("suspects", "Suspects: which effect is missing", suspects),
    ("ladder", "The ladder: the residual, step by step", ladder),
    ("equation", "The equation of motion", equation),
    ("setup", "Set-up and calibration", setup),
    ("capture", "Capture and verdict", capture),
    ("alignment", "Alignment of the channels", alignment),
    ("methods", "Appendix: identification by two methods", methods),
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

    with inked(PAPER):
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
