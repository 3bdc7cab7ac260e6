"""`station verify`: check a session's files against its manifest."""

from pathlib import Path

from station.commands.options import argument, declared, existing
from station.exits import STORAGE, Answered


@declared("verify")
def command(
    sessions: tuple[str, ...] = argument(
        nargs=-1, required=True, metavar="SESSION...", callback=existing("session")
    ),
) -> None:
    """Check SESSIONS against their manifests; one flipped bit is found."""
    from daq.session import verify
    from station.text.content import Table, Told
    from station.text.layout import answer

    checked = [verify(Path(folder)) for folder in sessions]
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
