"""`station verify`: does every file of a session still hold what was written?"""

from station.commands.options import JSON, SESSIONS, declared
from station.exits import STORAGE, Answered
from station.output import next_line, print_json, say
from station.settings import Settings


@declared("verify")
def command(
    settings: Settings,
    sessions: tuple[str, ...] = SESSIONS,
    as_json: bool = JSON,
) -> None:
    """Check SESSIONS against their manifests; one flipped bit is found."""
    from daq.session import verify
    from station.results.session_names import session_folder

    root = settings.sessions
    checked = [verify(session_folder(name, root)) for name in sessions]
    if as_json:
        entries = [
            {
                "session": str(c.folder),
                "ok": c.ok,
                "files": c.files,
                "problems": c.problems,
                "remarks": c.remarks,
            }
            for c in checked
        ]
        print_json({"ok": all(one.ok for one in checked), "sessions": entries})
    else:
        for one in checked:
            state = "all as they were written" if one.ok else "not all as they were written"
            say(f"{one.folder}: {one.files} files checked, {state}")
            for problem in (*one.problems, *one.remarks):
                say(f"  - {problem}")
        say(next_line("info", checked[0].folder))
    bad = sum(not one.ok for one in checked)
    if bad:
        raise Answered(f"{bad} of {len(checked)} sessions are not as they were written", STORAGE)
