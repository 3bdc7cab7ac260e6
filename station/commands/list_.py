"""`station list`: the sessions in a folder."""

from pathlib import Path
from typing import Any

from station.commands.options import JSON, argument, declared
from station.output import print_json, say, screen
from station.settings import Settings
from station.text.next_step import next_line


@declared("list")
def command(
    settings: Settings,
    folder: Path | None = argument(required=False),
    as_json: bool = JSON,
) -> None:
    """List the sessions in FOLDER (default: ./sessions), oldest first."""
    from daq.session import list_sessions
    from station.exits import UsageProblem

    place = folder or settings.sessions
    if folder is not None and not place.is_dir():
        raise UsageProblem(f"{place}: there is no such folder")
    found = list_sessions(place) if place.is_dir() else ()
    if as_json:
        print_json({"folder": str(place), "sessions": [_entry(summary) for summary in found]})
        return
    if not found:
        screen().print(
            f"no sessions in {place}; make one with `station demo`, `capture` or `import`", markup=False
        )
        return
    _print(found)


def _entry(summary: Any) -> dict[str, Any]:
    info = summary.info
    if info is None:
        return {"session": str(summary.folder), "problem": summary.problem}
    return {
        "session": str(summary.folder),
        "name": info.name,
        "created": info.created.isoformat(),
        "state": info.state.value,
        "verdict": getattr(info, "verdict", None) or None,
        "mass_kg": info.mass_kg,
        "rate_hz": info.rate_hz,
        "source": info.source,
    }


def _print(found: Any) -> None:
    from station.text.content import Table
    from station.text.layout import show_parts

    rows = []
    for summary in found:
        info = summary.info
        if info is None:
            rows.append((summary.folder.name, "", "damaged", summary.problem, ""))
            continue
        made = info.created.astimezone().strftime("%Y-%m-%d %H:%M")
        mass = "" if info.mass_kg is None else f"{info.mass_kg:g} kg"
        rows.append((summary.folder.name, made, info.state.value, getattr(info, "verdict", "") or "", mass))
    head = ("session", "made", "state", "verdict", "mass")
    show_parts(screen(), [Table("", head, tuple(rows), texts=5)])
    say(next_line("info", found[-1].folder))
