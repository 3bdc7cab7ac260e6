"""`station verify`: does every file of a session still hold what was written?"""

from typing import Any

import click

from station.commands.options import SESSIONS, pass_settings
from station.exits import STORAGE, Problem
from station.output import json_option, print_json, screen
from station.settings import Settings
from station.text.next_step import next_line


class Altered(Problem):
    """A session is not what was written; the message says how many problems there are."""

    exit_code = STORAGE
    reported = True


@click.command("verify")
@SESSIONS
@json_option
@pass_settings
def command(settings: Settings, sessions: tuple[str, ...], as_json: bool) -> None:
    """Check SESSIONS against their manifests; one flipped bit is found."""
    from daq.session import verify
    from station.results.session_names import session_folder

    root = settings.sessions
    checked = [verify(session_folder(name, root)) for name in sessions]
    if as_json:
        print_json({"ok": all(one.ok for one in checked), "sessions": [_entry(one) for one in checked]})
    else:
        for one in checked:
            state = "all as they were written" if one.ok else "not all as they were written"
            screen().print(f"{one.folder}: {one.files} files checked, {state}", markup=False, soft_wrap=True)
            for problem in (*one.problems, *one.remarks):
                screen().print(f"  - {problem}", markup=False, soft_wrap=True)
        screen().print(next_line("info", checked[0].folder), markup=False, soft_wrap=True)
    bad = sum(not one.ok for one in checked)
    if bad:
        raise Altered(f"{bad} of {len(checked)} sessions are not as they were written")


def _entry(one: Any) -> dict[str, Any]:
    return {
        "session": str(one.folder),
        "ok": one.ok,
        "files": one.files,
        "problems": list(one.problems),
        "remarks": list(one.remarks),
    }
