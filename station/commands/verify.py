"""`station verify`: check a session's files against its manifest."""

from station.commands.options import SESSIONS, declared
from station.exits import STORAGE, Answered
from station.settings import Settings


@declared("verify")
def command(
    settings: Settings,
    sessions: tuple[str, ...] = SESSIONS,
) -> None:
    """Check SESSIONS against their manifests; one flipped bit is found."""
    from daq.session import verify
    from station.results.session_names import session_folder
    from station.text.content import Table, Told
    from station.text.layout import answer

    checked = [verify(session_folder(name, settings.sessions)) for name in sessions]
    keys = ("ok", "files", "problems", "remarks")
    entries = [{"session": str(one.folder)} | {key: getattr(one, key) for key in keys} for one in checked]
    rows = []
    for one in checked:
        state = "all as they were written" if one.ok else "not all as they were written"
        rows.append((f"{one.folder}:", f"{one.files} files checked, {state}"))
        rows += [("", problem) for problem in (*one.problems, *one.remarks)]
    document = {"ok": all(one.ok for one in checked), "sessions": entries}
    table = Table("", ("", ""), tuple(rows), texts=2)
    answer(document, Told("", "", (table,)), "info", checked[0].folder)
    bad = sum(not one.ok for one in checked)
    if bad:
        raise Answered(f"{bad} of {len(checked)} sessions are not as they were written", STORAGE)
