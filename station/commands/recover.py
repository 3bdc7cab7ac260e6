"""`station recover`: seal a session that was cut off in mid-capture."""

from typing import Any

from station.commands.options import argument, declared
from station.exits import Answered, code_of
from station.settings import Settings


@declared("recover")
def command(
    settings: Settings,
    sessions: tuple[str, ...] = argument(nargs=-1),
) -> None:
    """Finish SESSIONS that were cut off (default: all of them).

    An unsealed session is sealed: everything up to the last whole record is
    kept; the raw bytes are never touched. A change of results that was cut
    off is completed.
    """
    from daq.errors import StationError
    from daq.session import recover, unsealed_sessions
    from station.results.session_names import session_folder
    from station.text.content import Table, Told
    from station.text.layout import answer

    unsealed = unsealed_sessions(settings.sessions) if settings.sessions.is_dir() else ()
    folders = [session_folder(name, settings.sessions) for name in sessions] or list(unsealed)
    entries, problems = [], []
    for folder in folders:
        try:
            entries.append(_entry(recover(folder)))
        except StationError as error:
            problems.append((folder, error))
    rows = []
    for entry in entries:
        rows.append((f"{entry['session']}:", f"{entry['state']}, {entry['samples']} samples"))
        changed = ", ".join(entry["completed"])
        rows += [("", f"a change was cut off and is complete now: {changed}")] if changed else []
        rows += [("", entry["reason"])] if entry["reason"] else []
    rows += [(f"{folder}:", f"NOT recovered: {problem}") for folder, problem in problems]
    told = [{"session": str(folder), "message": str(error)} for folder, error in problems]
    none = "" if folders else "nothing to recover: every session is whole"
    words = Told(none, "", (Table("", ("", ""), tuple(rows), texts=2),))
    step = ("identify", entries[0]["session"]) if entries else ("list",)
    answer({"sessions": entries, "problems": told}, words, *step)
    if problems:
        raise Answered(
            f"{len(problems)} of {len(folders)} sessions could not be recovered", code_of(problems[0][1])
        )


def _entry(session: Any) -> dict[str, Any]:
    counts = session.manifest().counts
    verdict = session.verdict
    return {
        "session": str(session.folder),
        "state": session.info.state.value,
        "reason": session.info.reason,
        "completed": list(session.completed),
        "samples": counts.samples,
        "lost_samples": counts.lost,
        "verdict": None if verdict is None else verdict.grade.value,
    }
