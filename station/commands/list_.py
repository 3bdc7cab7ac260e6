"""`station list`: list the sessions in a folder."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from station.commands.options import argument, declared
from station.settings import Settings
from station.text.content import Table, Told

if TYPE_CHECKING:
    from daq.session import SessionSummary

SHOWN = ("name", "created", "state", "mass_kg", "rate_hz", "source")


@declared("list")
def command(settings: Settings, folder: Path | None = argument(required=False)) -> None:
    """List the sessions in FOLDER (default: ./sessions), oldest first."""
    from daq.session import list_sessions
    from station.exits import UsageProblem
    from station.text.layout import answer

    place = folder or settings.sessions
    if folder is not None and not place.is_dir():
        raise UsageProblem(f"{place}: there is no such folder")
    found = list_sessions(place) if place.is_dir() else ()
    document = {"folder": str(place), "sessions": [_entry(summary) for summary in found]}
    none = f"no sessions in {place}; make one with `station demo`, `capture` or `import`"
    head = ("session", "made", "state", "verdict", "mass")
    table = (Table("", head, tuple(map(_row, found)), texts=5),) if found else ()
    step = ("info", found[-1].folder) if found else ()
    answer(document, Told(f"sessions in {place}" if found else none, "", table), *step)


def _entry(summary: "SessionSummary") -> dict[str, Any]:
    info = summary.info
    if info is None:
        return {"session": str(summary.folder), "problem": summary.problem}
    known = info.model_dump(mode="json", include=set(SHOWN))
    return {"session": str(summary.folder), **known, "verdict": info.verdict or None}


def _row(summary: "SessionSummary") -> tuple[str, ...]:
    info = summary.info
    if info is None:
        return (summary.folder.name, "", "damaged", summary.problem, "")
    made = info.created.astimezone().strftime("%Y-%m-%d %H:%M")
    mass = "" if info.mass_kg is None else f"{info.mass_kg:g} kg"
    return (summary.folder.name, made, info.state.value, info.verdict, mass)
